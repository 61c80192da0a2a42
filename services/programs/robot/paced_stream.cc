#include "services/programs/robot/paced_stream.h"

#include <cstdlib>
#include <utility>
#include <variant>

#include "absl/time/clock.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::NextFrame;
using client_agent::NoFrameYet;
using client_agent::StreamEnd;
using client_agent::StreamFrame;

namespace {

// Longest time for which a stream without frames keeps the robot from noticing that it is stopped.
constexpr absl::Duration kStopLatency = absl::Milliseconds(100);

}  // namespace

absl::StatusOr<std::optional<StreamFrame>> PacedStream::Await() {
  while (!stop_.HasBeenNotified()) {
    absl::StatusOr<NextFrame> next =
        ahead_.has_value() ? *std::move(ahead_) : stream_.Next(absl::Now() + kStopLatency);
    ahead_.reset();
    RETURN_IF_ERROR(next.status());
    if (auto* frame = std::get_if<StreamFrame>(&*next)) return std::move(*frame);
    if (std::holds_alternative<StreamEnd>(*next)) return std::nullopt;
  }
  return std::nullopt;
}

absl::Time PacedStream::Due(const StreamFrame& frame) const {
  // In a sequence that is played backwards times fall.
  return *start_ + absl::Nanoseconds(std::abs(frame.frame.timestamp_ns - first_ns_));
}

bool PacedStream::IsOvertaken(absl::Time now) {
  ahead_ = stream_.Next(now);
  if (!ahead_->ok()) return false;
  const auto* next = std::get_if<StreamFrame>(&**ahead_);
  if (next != nullptr) return now >= Due(*next);
  if (std::holds_alternative<NoFrameYet>(**ahead_)) ahead_.reset();
  return false;
}

absl::StatusOr<std::optional<StreamFrame>> PacedStream::Next() {
  while (true) {
    ASSIGN_OR_RETURN(std::optional<StreamFrame> frame, Await());
    if (!frame.has_value() || pace_ == Pace::kMax) return frame;
    const absl::Time now = absl::Now();
    // The clock starts when the first picture is there.
    if (!start_.has_value()) {
      start_ = now;
      first_ns_ = frame->frame.timestamp_ns;
    }
    if (IsOvertaken(now)) {
      ++dropped_;
      continue;
    }
    if (stop_.WaitForNotificationWithTimeout(Due(*frame) - absl::Now())) return std::nullopt;
    return frame;
  }
}

}  // namespace corbslam::services
