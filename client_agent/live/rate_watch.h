// Watches how often a camera gives frames.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_RATE_WATCH_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_RATE_WATCH_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/time/time.h"

namespace corbslam::client_agent {

// Counts frames over windows of kWindow. What is usual is the rate that is expected, or that of the
// first window with frames. Not thread-safe.
class RateWatch {
 public:
  static constexpr absl::Duration kWindow = absl::Seconds(5);
  // A rate below this share of the usual one has fallen.
  static constexpr double kFallen = 0.7;

  explicit RateWatch(std::optional<double> expected_hz) : usual_hz_(expected_hz) {}

  // Is told how many frames came until `now`, again and again. Returns a sentence when the rate
  // falls, stops, or is as usual again; nothing while it stays as it is.
  std::optional<std::string> Tell(absl::Time now, uint64_t frames);

  std::optional<double> usual_interval_s() const;
  // Returns whether no frame came in the last window.
  bool is_stopped() const { return state_ == State::kStopped; }

 private:
  enum class State { kUsual, kFallen, kStopped };
  std::string Describe(State state, double rate_hz) const;

  std::optional<double> usual_hz_;
  State state_ = State::kUsual;
  std::optional<absl::Time> begin_;  // Of the window.
  uint64_t frames_at_begin_ = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_RATE_WATCH_H_
