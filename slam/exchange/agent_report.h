// What a robot says of itself, for people: what it is doing, and how its frames fare.
#ifndef CORBSLAM_SLAM_EXCHANGE_AGENT_REPORT_H_
#define CORBSLAM_SLAM_EXCHANGE_AGENT_REPORT_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "slam/util/ids.h"

namespace corbslam {

enum class AgentActivity {
  kUnknown,
  kInitialising,  // Frames come, and none is good enough yet to begin with.
  kTracking,      // Frames come and have poses.
  kLost,          // Frames come and have none.
  kWaiting,       // No frame has come for more than two seconds, though the source has not ended.
  kFinished,      // The source has ended, and no frame will come.
};

// A map has another shape than the robot's own sight: over `way_m` of it the camera ends `shift_m`
// beside where it would by the map, whose length is not judged, and turned by `turn_rad` against
// it.
struct MapBend {
  double way_m = 0;
  double shift_m = 0;
  double turn_rad = 0;

  bool operator==(const MapBend&) const = default;
};

// One of others' local maps is not as the robot's own camera measures it.
struct MapContradiction {
  LocalMapId local_map;
  // How many times as large it is as what the camera measures, and the standard deviation of that;
  // 1 and 0 where its size is not what is wrong.
  double scale = 1;
  double scale_sigma = 0;
  std::optional<MapBend> bend = std::nullopt;

  bool operator==(const MapContradiction&) const = default;
};

// Says how the other map is, as the end of "local map ... is": "1.40 % smaller than what its camera
// measures (+-0.16 %)", where "its" is the robot that measured.
std::string Describe(const MapContradiction& found);

struct AgentReport {
  // So many contradicting local maps are told at most.
  static constexpr size_t kMaxContradictions = 100;

  AgentActivity activity = AgentActivity::kUnknown;
  // Frames that were given to the robot since its process began, those of them that had a pose and
  // that were lost, and those that came too fast and were not looked at.
  uint64_t frames = 0;
  uint64_t tracked = 0;
  uint64_t lost = 0;
  uint64_t dropped = 0;
  // Time of the newest frame, 0 to 2^62, and how long ago it came when this was said.
  int64_t newest_timestamp_ns = 0;
  double newest_frame_age_s = 0;
  // The local maps that the robot goes without, since its process began.
  std::vector<MapContradiction> contradictions = {};

  bool operator==(const AgentReport&) const = default;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EXCHANGE_AGENT_REPORT_H_
