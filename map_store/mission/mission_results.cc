// What becomes of fusion work in Mission: it had nothing to do, it has a result, it failed.
#include <algorithm>

#include "absl/strings/str_cat.h"
#include "map_store/mission/mission.h"
#include "map_store/records/record_application.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Something that the plan places.
bool WasPlacedSince(uint64_t revision, const RevisionPlan& plan, const GlobalLayer& global) {
  return std::ranges::any_of(plan.keyframes, [&](const auto& planned) {
    const auto it = global.keyframes.find(planned.first);
    return it != global.keyframes.end() && it->second.revision > revision;
  });
}

void GiveUpAdjustment(const MissionState& state, Island& island) {
  island.needs_adjustment = false;
  island.dirty = false;
  island.overlaps_since_adjustment = 0;
  island.adjusted = CountKeyframes(state, island);
  island.displaced.clear();
  island.moved.clear();
}

}  // namespace

void Mission::SkipAction(const FusionAction& action) {
  if (action.kind == FusionAction::Kind::kQuery) {
    state_.queries.PopFront();
    return;
  }
  if (action.kind == FusionAction::Kind::kAdjust) {
    const auto island = state_.global.islands.find(action.target);
    if (island != state_.global.islands.end()) GiveUpAdjustment(state_, island->second);
    return;
  }
  for (const uint64_t id : action.overlaps) {
    state_.global.overlaps.Change(id, [](OverlapEntry& entry) {
      Refuse("its keyframes were removed", OverlapState::kFailed, entry);
    });
  }
  Island& island = state_.global.islands.at(action.target);
  const std::vector<LocalMapId> relaxed(island.relaxed.begin(), island.relaxed.end());
  LeaveToAdjustment(relaxed, state_, island);
}

absl::Status Mission::Commit(const FusionJob& job, const FusionResult& result) {
  absl::MutexLock turn(&writer_mutex_);
  if (IsDeleted() || job.cancelled->load()) return absl::OkStatus();
  if (const auto* query = std::get_if<QueryJob>(&job.work)) {
    return CommitQuery(*query, std::get<VerifyOverlapResult>(result));
  }
  if (const auto* fuse = std::get_if<FuseJob>(&job.work)) {
    return CommitFuse(*fuse, std::get<FuseMapsResult>(result));
  }
  return CommitAdjust(std::get<AdjustJob>(job.work), std::get<AdjustBundleResult>(result));
}

absl::Status Mission::CommitQuery(const QueryJob& job, const VerifyOverlapResult& result) {
  const QueryRecord record{job.task, result.overlaps, environment_.clock()};
  RETURN_IF_ERROR(Append(record));
  absl::MutexLock lock(&mutex_);
  map_store::Apply(record, *environment_.options, state_);
  return absl::OkStatus();
}

absl::Status Mission::CommitFuse(const FuseJob& job, const FuseMapsResult& result) {
  if (!result.accepted) {
    const FuseRefusedRecord record{job.action.target, job.new_overlaps, job.relaxed,
                                   result.worst_edge_chi2};
    RETURN_IF_ERROR(Append(record));
    absl::MutexLock lock(&mutex_);
    map_store::Apply(record, state_);
    if (!job.relaxed.empty()) CancelAdjustment(job.action);
    return absl::OkStatus();
  }
  FuseRecord record;
  record.relaxed = job.relaxed;
  {
    absl::ReaderMutexLock lock(&mutex_);
    record.plan = PlanFuse(state_, job, result);
    record.merge_ms = SinceVerified(record.plan.overlaps);
  }
  // Where all was adjusted since, poses from before would undo that; fused anew, they don't. After
  // an urgent one all is adjusted again.
  if (IsOvertaken(job, record)) return absl::OkStatus();
  // Only writers change what the plan was made of, and this one has the turn.
  RETURN_IF_ERROR(Append(record));
  absl::MutexLock lock(&mutex_);
  const bool urgent = map_store::Apply(record, *environment_.options, state_);
  if (urgent) CancelAdjustment(job.action);
  return absl::OkStatus();
}

void Mission::CancelAdjustment(const FusionAction& overtaken_by) {
  const Lane& lane = lanes_[static_cast<size_t>(FusionLane::kAdjustment)];
  const bool stale = lane.target == overtaken_by.target || lane.target == overtaken_by.source;
  if (!stale || lane.cancelled == nullptr || lane.cancelled->exchange(true)) return;
  ++adjustment_trouble_[overtaken_by.target].cancelled;
}

bool Mission::IsOvertaken(const FuseJob& job, const FuseRecord& record) const {
  absl::ReaderMutexLock lock(&mutex_);
  return !IsUrgent(record, state_) &&
         WasPlacedSince(job.request.base_revision, record.plan, state_.global);
}

double Mission::SinceVerified(const std::vector<uint64_t>& overlaps) const {
  absl::Time first = absl::InfiniteFuture();
  for (const uint64_t id : overlaps) {
    first = std::min(first, state_.global.overlaps.at(id).verified_at);
  }
  return overlaps.empty() ? 0 : absl::ToDoubleMilliseconds(environment_.clock() - first);
}

absl::Status Mission::CommitAdjust(const AdjustJob& job, const AdjustBundleResult& result) {
  AdjustRecord record;
  {
    absl::ReaderMutexLock lock(&mutex_);
    const auto it = state_.global.islands.find(job.snapshot.island);
    if (it == state_.global.islands.end()) return absl::OkStatus();
    if (it->second.generation != job.snapshot.generation) return absl::OkStatus();
    record.plan = PlanAdjust(state_, job, result);
    // What arrived or was welded while the worker was busy waits for the next one.
    record.dirty = it->second.version_of_owners > job.snapshot.version_of_owners ||
                   WasPlacedSince(job.request.base_revision, record.plan, state_.global);
  }
  record.statistics = {result.keyframes, result.points, result.iterations, result.seconds * 1e3};
  RETURN_IF_ERROR(Append(record));
  absl::MutexLock lock(&mutex_);
  map_store::Apply(record, *environment_.options, state_);
  adjustment_trouble_.erase(record.plan.target);
  return absl::OkStatus();
}

void Mission::NoteFailure(const FusionJob& job, const absl::Status& status) {
  if (deleted_) return;
  ++state_.statistics.failed_requests;
  const int max_attempts = environment_.options->max_attempts;
  if (std::holds_alternative<QueryJob>(job.work)) {
    const QueryTask task = state_.queries.front();
    if (state_.queries.CountFailureOfFront() < max_attempts) return;
    ++state_.failed_queries[{task.query.local_map, task.against}];
    state_.queries.PopFront();
    return;
  }
  if (const auto* fuse = std::get_if<FuseJob>(&job.work)) {
    for (const uint64_t id : fuse->action.overlaps) {
      state_.global.overlaps.Change(id, [&](OverlapEntry& entry) {
        if (++entry.attempts < max_attempts) return;
        Refuse(absl::StrCat("worker failed: ", status.message()), OverlapState::kFailed, entry);
      });
    }
    LeaveToAdjustment(fuse->relaxed, state_, state_.global.islands.at(fuse->action.target));
    return;
  }
  const IslandId id = std::get<AdjustJob>(job.work).snapshot.island;
  const auto island = state_.global.islands.find(id);
  if (++adjustment_trouble_[id].failed < max_attempts || island == state_.global.islands.end()) {
    return;
  }
  adjustment_trouble_.erase(id);
  GiveUpAdjustment(state_, island->second);
}

}  // namespace corbslam::map_store
