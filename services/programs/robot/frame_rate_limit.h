// Leaves out frames that come faster than a robot is to track them.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_FRAME_RATE_LIMIT_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_FRAME_RATE_LIMIT_H_

#include <atomic>
#include <cstdint>
#include <limits>

namespace corbslam::services {

// By the frames' own times. One thread takes frames; the rest is thread-safe.
class FrameRateLimit {
 public:
  // Frames a second; 0: all are taken.
  void Set(double rate_hz) { rate_hz_ = rate_hz; }

  // Returns whether the next frame, of this time, is to be tracked.
  bool Takes(int64_t timestamp_ns) {
    const double rate_hz = rate_hz_;
    if (!(rate_hz > 0)) {
      due_ns_ = kNever;
      return true;
    }
    const double interval_ns = 1e9 / rate_hz;
    const double early_ns = static_cast<double>(due_ns_) - static_cast<double>(timestamp_ns);
    // A camera's times waver; and where they go back, a new drive begins.
    const bool is_due = due_ns_ == kNever || early_ns <= kWaver * interval_ns ||
                        early_ns > (1 + kWaver) * interval_ns;
    if (!is_due) {
      ++left_out_;
      return false;
    }
    // The schedule is kept where the frame is nearly in time, so that the rate holds on average.
    const bool keeps =
        due_ns_ != kNever && early_ns <= kWaver * interval_ns && early_ns > -interval_ns;
    due_ns_ = (keeps ? due_ns_ : timestamp_ns) + static_cast<int64_t>(interval_ns);
    return true;
  }
  uint64_t left_out() const { return left_out_; }

 private:
  static constexpr int64_t kNever = std::numeric_limits<int64_t>::min();
  static constexpr double kWaver = 0.1;

  std::atomic<double> rate_hz_ = 0;
  std::atomic<uint64_t> left_out_ = 0;
  int64_t due_ns_ = kNever;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_FRAME_RATE_LIMIT_H_
