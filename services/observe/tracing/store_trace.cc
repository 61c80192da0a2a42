#include "services/observe/tracing/store_trace.h"

#include <variant>

#include "absl/time/clock.h"

namespace corbslam::services {

void StoreTrace::OnBatch(const SessionAgent& agent, const MapUpdateBatch& batch) {
  const absl::Time now = absl::Now();
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    file_.Add({kReceived, keyframe.payload->id, now, agent.mission, agent.agent});
  }
}

void StoreTrace::OnApplied(const SessionAgent& agent, const MapUpdateBatch& batch, absl::Duration,
                           const absl::Status& status) {
  if (!status.ok()) return;
  const absl::Time now = absl::Now();
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    file_.Add({kDurable, keyframe.payload->id, now, agent.mission, agent.agent});
  }
}

void StoreTrace::OnShared(const SessionAgent& agent, const SharedUpdate& update) {
  const absl::Time now = absl::Now();
  for (const SharedKeyframe& keyframe : update.keyframes) {
    file_.Add({kShared, keyframe.payload->id, now, agent.mission, agent.agent});
  }
}

void StoreTrace::OnAppended(absl::string_view mission, const map_store::JournalRecord& record,
                            absl::Duration, const absl::Status& status) {
  if (!status.ok()) return;
  absl::MutexLock lock(&mutex_);
  const auto it = missions_.try_emplace(std::string(mission)).first;
  Seen& seen = it->second;
  if (const auto* batch = std::get_if<map_store::BatchRecord>(&record)) {
    seen.owners.try_emplace(batch->batch->local_map, batch->agent);
  } else if (const auto* fuse = std::get_if<map_store::FuseRecord>(&record)) {
    NoteRevision(kPlaced, it->first, fuse->plan, seen, seen.placed);
  } else if (const auto* adjust = std::get_if<map_store::AdjustRecord>(&record)) {
    NoteRevision(kPlaced, it->first, adjust->plan, seen, seen.placed);
    NoteRevision(kAdjusted, it->first, adjust->plan, seen, seen.adjusted);
  }
}

void StoreTrace::NoteRevision(absl::string_view name, const std::string& mission,
                              const map_store::RevisionPlan& plan, const Seen& seen,
                              std::set<KeyframeId>& once) {
  const absl::Time now = absl::Now();
  for (const auto& [id, placed] : plan.keyframes) {
    if (!once.insert(id).second) continue;
    const auto owner = seen.owners.find(id.local_map);
    file_.Add({name, id, now, mission, owner == seen.owners.end() ? "" : owner->second});
  }
}

void StoreTrace::OnDeleted(absl::string_view mission) {
  absl::MutexLock lock(&mutex_);
  const auto it = missions_.find(mission);
  if (it != missions_.end()) missions_.erase(it);
}

}  // namespace corbslam::services
