// Notices that pictures come and no pose goes out, or that one side of a pair is gone.
#ifndef CORBSLAM_SERVICES_ROS2_SILENCE_WATCH_H_
#define CORBSLAM_SERVICES_ROS2_SILENCE_WATCH_H_

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace corbslam::services {

// What came and what went out since the beginning.
struct FlowCounts {
  uint64_t pictures[2] = {0, 0};
  uint64_t frames = 0;  // That were tracked or tried.
  uint64_t poses = 0;   // That went out.
};

enum class Silence {
  kNone,
  kNoPictures,  // Of either side.
  kFirstGone,   // The other side's pictures come.
  kSecondGone,
  kNoFrames,  // Pictures of both sides come, and none are a frame.
  kNoPoses,   // Frames are tried, and none has a pose.
};

// Not thread-safe.
class SilenceWatch {
 public:
  using Moment = std::chrono::steady_clock::time_point;
  explicit SilenceWatch(std::chrono::nanoseconds silent_after) : silent_after_(silent_after) {}

  // Is told of the counts again and again. Returns what has been silent for as long as it may be.
  Silence Tell(const FlowCounts& counts, Moment now);
  // Returns since when it has been so; zero where nothing is silent.
  std::chrono::nanoseconds silent_for() const { return silent_for_; }

 private:
  struct Flow {
    uint64_t count = 0;
    std::optional<Moment> last;  // When it grew, or watching began.
  };
  std::chrono::nanoseconds Quiet(Flow& flow, uint64_t count, Moment now) const;

  const std::chrono::nanoseconds silent_after_;
  Flow pictures_[2];
  Flow frames_;
  Flow poses_;
  std::chrono::nanoseconds silent_for_{0};
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_ROS2_SILENCE_WATCH_H_
