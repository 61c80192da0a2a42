#include "services/programs/robot/paced_stream.h"

#include <algorithm>
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

absl::StatusOr<NextFrame> PacedStream::Ask(absl::Time deadline) {
  const absl::Time asked = absl::Now();
  absl::StatusOr<NextFrame> next = stream_.Next(deadline);
  if (pace_ != Pace::kSensor || stream_.is_live() || !start_.has_value() || !next.ok()) return next;
  const auto* const frame = std::get_if<StreamFrame>(&*next);
  if (frame == nullptr) return next;
  if (frame->frame.drive != drive_) return next;
  const absl::Time came = absl::Now();
  const absl::Duration late = std::max(came - Due(*frame), absl::ZeroDuration());
  const absl::Duration held = std::min(late, came - asked);
  *start_ += held;
  source_pace_.OnFrame(came, held);
  return next;
}

absl::StatusOr<std::optional<StreamFrame>> PacedStream::Await() {
  while (!stop_.HasBeenNotified()) {
    absl::StatusOr<NextFrame> next =
        ahead_.has_value() ? *std::move(ahead_) : Ask(absl::Now() + kStopLatency);
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
  ahead_ = Ask(now);
  if (!ahead_->ok()) return false;
  const auto* next = std::get_if<StreamFrame>(&**ahead_);
  if (next != nullptr) return next->frame.drive == drive_ && now >= Due(*next);
  if (std::holds_alternative<NoFrameYet>(**ahead_)) ahead_.reset();
  return false;
}

absl::StatusOr<std::optional<StreamFrame>> PacedStream::Next() {
  while (true) {
    ASSIGN_OR_RETURN(std::optional<StreamFrame> frame, Await());
    // A camera's frame is due when it comes, whatever clock stamped it.
    if (!frame.has_value() || pace_ != Pace::kSensor || frame->came.has_value()) return frame;
    const absl::Time now = absl::Now();
    // The clock starts when a drive's first picture is there.
    if (!start_.has_value() || drive_ != frame->frame.drive) {
      start_ = now;
      first_ns_ = frame->frame.timestamp_ns;
      drive_ = frame->frame.drive;
    }
    if (IsOvertaken(now)) {
      ++dropped_;
      kept_imu_.Keep(frame->frame.drive, std::move(frame->images.imu));
      continue;
    }
    kept_imu_.GiveTo(frame->frame.drive, frame->images.imu);
    if (stop_.WaitForNotificationWithTimeout(Due(*frame) - absl::Now())) return std::nullopt;
    return frame;
  }
}

}  // namespace corbslam::services
