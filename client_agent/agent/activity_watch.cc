#include "client_agent/agent/activity_watch.h"

#include <algorithm>

namespace corbslam::client_agent {
namespace {

// The largest time that a report may have.
constexpr int64_t kMostTime_ns = int64_t{1} << 62;

}  // namespace

void ActivityWatch::NoteFrame(const TrackingResult& result, Moment came, uint64_t dropped) {
  absl::MutexLock lock(&mutex_);
  ++counts_.frames;
  if (result.state == TrackingState::kTracking) ++counts_.tracked;
  if (result.state == TrackingState::kLost) ++counts_.lost;
  counts_.dropped = dropped;
  counts_.newest_timestamp_ns = std::clamp<int64_t>(result.timestamp_ns, 0, kMostTime_ns);
  state_ = result.state;
  newest_ = came;
}

void ActivityWatch::NoteEnd() {
  absl::MutexLock lock(&mutex_);
  ended_ = true;
}

AgentActivity ActivityWatch::Judge(Moment now) const {
  if (ended_) return AgentActivity::kFinished;
  if (now - newest_.value_or(began_) > kWaitsAfter) return AgentActivity::kWaiting;
  switch (state_) {
    case TrackingState::kNotInitialised:
      return AgentActivity::kInitialising;
    case TrackingState::kTracking:
      return AgentActivity::kTracking;
    case TrackingState::kLost:
      return AgentActivity::kLost;
  }
  return AgentActivity::kUnknown;
}

AgentReport ActivityWatch::Report() const {
  const Moment now = clock_();
  absl::MutexLock lock(&mutex_);
  AgentReport report = counts_;
  report.activity = Judge(now);
  if (newest_.has_value()) {
    const std::chrono::duration<double> age = now - *newest_;
    report.newest_frame_age_s = std::max(age.count(), 0.0);
  }
  return report;
}

}  // namespace corbslam::client_agent
