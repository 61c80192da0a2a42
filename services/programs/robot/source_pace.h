// Measures whether a source that makes its frames when it is asked, a recording or a simulator,
// keeps up with the frames' own times.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_SOURCE_PACE_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_SOURCE_PACE_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/time/time.h"
#include "slam/util/rare_reminder.h"

namespace corbslam::services {

// How long the robot's clock had to wait for the source. A value.
class SourcePace {
 public:
  // A frame came after the first one; the clock had been held for it.
  void OnFrame(absl::Time came, absl::Duration held);

  absl::Duration held() const { return held_; }
  // Returns the time from frame to frame, as they came.
  absl::Duration frame_time() const;
  uint64_t frames() const { return frames_; }
  // Returns true where the clock waited for more than a second and a tenth of the time.
  bool IsTooSlow() const;

 private:
  uint64_t frames_ = 0;
  absl::Duration held_;
  absl::Time first_;
  absl::Time last_;
};

// Says how slow the source is and what can be done. `interval_s`: seconds between frames by their
// own times, where known.
std::string DescribeSlowSource(const SourcePace& pace, std::optional<double> interval_s);

// Logs it, first when it is clear, then more and more seldom. Not thread-safe.
class SlowSourceLog {
 public:
  void Tell(const SourcePace& pace, std::optional<double> interval_s, absl::Time now);

 private:
  RareReminder reminder_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_SOURCE_PACE_H_
