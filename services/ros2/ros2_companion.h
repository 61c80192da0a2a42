// A robot as a node of ROS 2: publishes what becomes of its frames, and takes orders.
#ifndef CORBSLAM_SERVICES_ROS2_ROS2_COMPANION_H_
#define CORBSLAM_SERVICES_ROS2_ROS2_COMPANION_H_

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/synchronization/notification.h"
#include "client_agent/live/ros2/ros2_context.h"
#include "services/programs/robot_companion.h"
#include "services/ros2/outside_odometry.h"
#include "services/ros2/ros2_diagnosis.h"
#include "services/ros2/ros2_outputs.h"
#include "services/ros2/ros2_poses.h"
#include "services/ros2/silence_watch.h"

namespace corbslam::services {

// Poses go out from the thread that tracks; diagnostics, path and near map once a second from one
// of its own, which begins before the camera is there.
class Ros2Companion : public RobotCompanion {
 public:
  explicit Ros2Companion(std::shared_ptr<client_agent::Ros2Context> context)
      : context_(std::move(context)),
        silence_(std::chrono::nanoseconds(
            static_cast<int64_t>(1e9 * context_->settings().silent_after_s))) {}
  ~Ros2Companion() override;

  absl::Status Prepare() override;
  absl::Status Begin(const RobotView& robot) override ABSL_LOCKS_EXCLUDED(robot_mutex_);
  void OnFrame(const client_agent::TrackingResult& result, const FrameMoment& moment) override
      ABSL_LOCKS_EXCLUDED(frames_mutex_);
  void OnEnd() override ABSL_LOCKS_EXCLUDED(robot_mutex_);
  v1::AgentClock clock() const override { return v1::AGENT_CLOCK_RECORDED; }

 private:
  // What is kept of the frames, for the path and the lines of diagnostics.
  struct Frames {
    LocalMapId local_map;
    std::deque<StampedMotion> path;  // local_from_base, of the local map in use.
    std::optional<Similarity3d> map_from_local;
    uint64_t dropped = 0;
    std::optional<double> latency_ms;
    std::optional<double> stamp_ahead_s;
  };

  absl::Status Serve(const RobotView& robot);
  void LeaveOdomToOthers();
  void Keep(const Ros2Poses& poses, const FrameMoment& moment) ABSL_LOCKS_EXCLUDED(frames_mutex_);
  void Work();
  void PublishMap() ABSL_EXCLUSIVE_LOCKS_REQUIRED(robot_mutex_) ABSL_LOCKS_EXCLUDED(frames_mutex_);
  Ros2Facts Collect() ABSL_EXCLUSIVE_LOCKS_REQUIRED(robot_mutex_)
      ABSL_LOCKS_EXCLUDED(frames_mutex_);
  std::vector<std::string> Conflicts() const;
  // Logs a silence when it begins, and when it ends.
  void TellSilence(const Ros2Facts& facts);

  const std::shared_ptr<client_agent::Ros2Context> context_;
  std::unique_ptr<Ros2Outputs> outputs_;
  OutsideOdometry outside_;
  Ros2Mounting mounting_;  // Set before the first frame.
  std::atomic<uint64_t> frame_count_ = 0;
  std::atomic<uint64_t> pose_count_ = 0;
  SilenceWatch silence_;                   // Only the worker uses it.
  Silence told_silence_ = Silence::kNone;  // Likewise.
  absl::Notification stop_;
  std::thread worker_;

  absl::Mutex robot_mutex_;
  std::optional<RobotView> robot_ ABSL_GUARDED_BY(robot_mutex_);
  bool has_ended_ ABSL_GUARDED_BY(robot_mutex_) = false;
  std::string name_ ABSL_GUARDED_BY(robot_mutex_);

  absl::Mutex frames_mutex_ ABSL_ACQUIRED_AFTER(robot_mutex_);
  Frames frames_ ABSL_GUARDED_BY(frames_mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_ROS2_ROS2_COMPANION_H_
