#include "client_agent/agent/agent_events.h"

#include <utility>

namespace corbslam::client_agent {
namespace {

AgentEvent::Kind KindOf(LinkEvent event) {
  switch (event) {
    case LinkEvent::kMerged:
      return AgentEvent::Kind::kMerged;
    case LinkEvent::kSplit:
      return AgentEvent::Kind::kSplit;
    case LinkEvent::kMissionDeleted:
      return AgentEvent::Kind::kMissionDeleted;
  }
  return AgentEvent::Kind::kMissionDeleted;
}

}  // namespace

std::optional<AgentEvent::Kind> AgentEvents::Judge(const TrackingResult& result) const {
  const bool had_pose = newest_.state == TrackingState::kTracking;
  if (result.state != TrackingState::kTracking) {
    const bool is_lost = had_pose && result.state == TrackingState::kLost;
    return is_lost ? std::optional(Kind::kLost) : std::nullopt;
  }
  if (result.local_map != last_tracked_) return Kind::kLocalMapBegun;
  if (!had_pose) return Kind::kRelocalised;
  return result.epoch != newest_.epoch ? std::optional(Kind::kMapCorrected) : std::nullopt;
}

void AgentEvents::NoteFrame(const TrackingResult& result, uint64_t global_epoch) {
  bool has_news = false;
  {
    absl::MutexLock lock(&mutex_);
    const std::optional<Kind> kind = Judge(result);
    const bool global_moved = global_epoch != global_epoch_;
    newest_ = result;
    global_epoch_ = global_epoch;
    if (result.state == TrackingState::kTracking) last_tracked_ = result.local_map;
    if (kind.has_value()) Add(*kind, result.local_map);
    if (global_moved) Add(Kind::kGlobalFrameMoved, result.local_map);
    if (kind == Kind::kLocalMapBegun) {
      begun_.insert(result.local_map);
      if (merged_early_ == result.local_map) {
        Add(Kind::kMerged, result.local_map);
        merged_early_.reset();
      }
    }
    has_news = kind.has_value() || global_moved;
  }
  if (has_news) CallListeners();
}

bool AgentEvents::Begins(LinkEvent event, LocalMapId local_map) {
  if (event == LinkEvent::kMissionDeleted || begun_.contains(local_map)) return true;
  merged_early_ = event == LinkEvent::kMerged ? std::optional(local_map) : std::nullopt;
  return false;
}

void AgentEvents::NoteLink(LinkEvent event, LocalMapId local_map) {
  {
    absl::MutexLock lock(&mutex_);
    if (!Begins(event, local_map)) return;
    Add(KindOf(event), local_map);
  }
  CallListeners();
}

void AgentEvents::NoteEnd() {
  {
    absl::MutexLock lock(&mutex_);
    if (ended_.has_value()) return;
    Add(Kind::kEnded, newest_.local_map);
    ended_ = last_number_;
  }
  CallListeners();
}

std::optional<uint64_t> AgentEvents::ended() const {
  absl::MutexLock lock(&mutex_);
  return ended_;
}

void AgentEvents::Add(Kind kind, LocalMapId local_map) {
  events_.push_back({.number = ++last_number_,
                     .time = clock_(),
                     .timestamp_ns = newest_.timestamp_ns,
                     .kind = kind,
                     .local_map = local_map,
                     .epoch = newest_.epoch,
                     .global_epoch = global_epoch_});
  if (events_.size() > kMaxEvents) events_.pop_front();
}

std::optional<AgentEvent> AgentEvents::After(uint64_t number) const {
  absl::MutexLock lock(&mutex_);
  if (number > last_number_) number = 0;
  if (events_.empty() || number == last_number_) return std::nullopt;
  const uint64_t oldest = events_.front().number;
  return events_[number < oldest ? 0 : number + 1 - oldest];
}

uint64_t AgentEvents::AddListener(std::function<void()> listener) {
  absl::MutexLock lock(&listeners_mutex_);
  listeners_.emplace(++last_token_, std::move(listener));
  return last_token_;
}

void AgentEvents::RemoveListener(uint64_t token) {
  absl::MutexLock lock(&listeners_mutex_);
  listeners_.erase(token);
}

void AgentEvents::CallListeners() {
  absl::MutexLock lock(&listeners_mutex_);
  for (const auto& [token, listener] : listeners_) listener();
}

}  // namespace corbslam::client_agent
