#include "client_agent/live/rate_watch.h"

#include "absl/strings/str_format.h"

namespace corbslam::client_agent {

std::optional<std::string> RateWatch::Tell(absl::Time now, uint64_t frames) {
  if (!begin_.has_value()) begin_ = now;
  const absl::Duration passed = now - *begin_;
  if (passed < kWindow) return std::nullopt;
  const uint64_t count = frames - frames_at_begin_;
  begin_ = now;
  frames_at_begin_ = frames;
  const double rate_hz = static_cast<double>(count) / absl::ToDoubleSeconds(passed);
  if (!usual_hz_.has_value() && count > 0) usual_hz_ = rate_hz;
  State state = State::kUsual;
  if (count == 0) {
    state = State::kStopped;
  } else if (rate_hz < kFallen * usual_hz_.value_or(0)) {
    state = State::kFallen;
  }
  if (state == state_) return std::nullopt;
  state_ = state;
  return Describe(state, rate_hz);
}

std::string RateWatch::Describe(State state, double rate_hz) const {
  switch (state) {
    case State::kStopped:
      return absl::StrFormat("no frame for %.0f s; waiting for the camera",
                             absl::ToDoubleSeconds(kWindow));
    case State::kFallen:
      return absl::StrFormat(
          "%.1f frames/s where %.1f are usual: is the exposure long, the cable "
          "or the bus too slow?",
          rate_hz, usual_hz_.value_or(0));
    case State::kUsual:
      break;
  }
  return absl::StrFormat("%.1f frames/s again", rate_hz);
}

std::optional<double> RateWatch::usual_interval_s() const {
  if (!usual_hz_.has_value() || *usual_hz_ <= 0) return std::nullopt;
  return 1 / *usual_hz_;
}

}  // namespace corbslam::client_agent
