// Logs for people why a robot doesn't know where it is, for as long as it doesn't.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_NO_POSE_LOG_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_NO_POSE_LOG_H_

#include <cstdint>
#include <optional>
#include <string>

#include "client_agent/tracking/tracking_result.h"
#include "slam/sensor/sensor.h"

namespace corbslam::services {

// Decides what is worth a line, by the frames' own times. Not thread-safe.
class NoPoseLog {
 public:
  // So much of the pictures is left out by the rig's mask.
  explicit NoPoseLog(double masked_percent = 0) : masked_percent_(masked_percent) {}

  // Takes the next frame's result and pictures. Returns a line once the pose has been missing for a
  // second and then every ten, and one when it is there after such a line; else nullopt.
  std::optional<std::string> Add(const client_agent::TrackingResult& result,
                                 const SensorImages& images);

 private:
  std::optional<std::string> AddTracked(const client_agent::TrackingResult& result);
  double Since_s(int64_t timestamp_ns) const;

  double masked_percent_;
  // Of the first frame without a pose.
  std::optional<int64_t> missing_since_ns_;
  double told_s_ = 0;  // For how long it had been missing in the last line; 0: none yet.
  std::optional<LocalMapId> last_map_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_NO_POSE_LOG_H_
