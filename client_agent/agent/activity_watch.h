// Knows what a robot is doing: whether frames come, and what became of them.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_ACTIVITY_WATCH_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_ACTIVITY_WATCH_H_

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/tracking/tracking_result.h"
#include "slam/exchange/agent_report.h"

namespace corbslam::client_agent {

// Thread-safe.
class ActivityWatch {
 public:
  using Moment = std::chrono::steady_clock::time_point;
  // A robot waits where its newest frame, or its own beginning, is longer ago.
  static constexpr std::chrono::seconds kWaitsAfter{2};

  explicit ActivityWatch(std::function<Moment()> clock = &std::chrono::steady_clock::now)
      : clock_(std::move(clock)), began_(clock_()) {}

  // Notes a frame that was given to the agent, and when it had come. `dropped` counts the frames so
  // far that came too fast.
  void NoteFrame(const TrackingResult& result, Moment came, uint64_t dropped);
  // Notes that no frame will come any more.
  void NoteEnd();

  // Returns the report as of now.
  AgentReport Report() const;

 private:
  AgentActivity Judge(Moment now) const ABSL_SHARED_LOCKS_REQUIRED(mutex_);

  const std::function<Moment()> clock_;
  const Moment began_;

  mutable absl::Mutex mutex_;
  AgentReport counts_ ABSL_GUARDED_BY(mutex_);  // Activity and age are of each report.
  TrackingState state_ ABSL_GUARDED_BY(mutex_) = TrackingState::kNotInitialised;
  std::optional<Moment> newest_ ABSL_GUARDED_BY(mutex_);
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_ACTIVITY_WATCH_H_
