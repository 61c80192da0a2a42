#include "services/ros2/silence_watch.h"

#include <algorithm>

namespace corbslam::services {

std::chrono::nanoseconds SilenceWatch::Quiet(Flow& flow, uint64_t count, Moment now) const {
  if (!flow.last.has_value() || count != flow.count) flow = {count, now};
  return now - *flow.last;
}

Silence SilenceWatch::Tell(const FlowCounts& counts, Moment now) {
  const std::chrono::nanoseconds first = Quiet(pictures_[0], counts.pictures[0], now);
  const std::chrono::nanoseconds second = Quiet(pictures_[1], counts.pictures[1], now);
  const std::chrono::nanoseconds frames = Quiet(frames_, counts.frames, now);
  const std::chrono::nanoseconds poses = Quiet(poses_, counts.poses, now);
  const auto is = [&](std::chrono::nanoseconds quiet) {
    if (quiet < silent_after_) return false;
    silent_for_ = quiet;
    return true;
  };
  silent_for_ = std::chrono::nanoseconds(0);
  if (is(std::min(first, second))) return Silence::kNoPictures;
  if (is(first)) return Silence::kFirstGone;
  if (is(second)) return Silence::kSecondGone;
  if (is(frames)) return Silence::kNoFrames;
  if (is(poses)) return Silence::kNoPoses;
  return Silence::kNone;
}

}  // namespace corbslam::services
