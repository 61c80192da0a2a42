// Says what becomes of fusion work that had nothing to do, has a result, or failed.
#include <algorithm>

#include "absl/strings/str_cat.h"
#include "map_store/mission/fusion_coordinator.h"
#include "map_store/records/record_application.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Returns whether something that the plan places was placed after `revision`.
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

void FusionCoordinator::SkipAction(const FusionAction& action) {
  MissionState& state = strand_.mutable_state();
  if (action.kind == FusionAction::Kind::kQuery) {
    state.queries.PopFront();
    return;
  }
  if (action.kind == FusionAction::Kind::kAdjust) {
    const auto island = state.global.islands.find(action.target);
    if (island != state.global.islands.end()) GiveUpAdjustment(state, island->second);
    return;
  }
  for (const uint64_t id : action.overlaps) {
    state.global.overlaps.Change(id, [](OverlapEntry& entry) {
      Refuse("its keyframes were removed", OverlapState::kFailed, entry);
    });
  }
  const auto island = state.global.islands.find(action.target);
  if (island == state.global.islands.end()) return;
  const std::vector<LocalMapId> relaxed(island->second.relaxed.begin(),
                                        island->second.relaxed.end());
  LeaveToAdjustment(relaxed, state, island->second);
}

absl::Status FusionCoordinator::Commit(const FusionJob& job, const FusionResult& result) {
  absl::MutexLock turn(&strand_.turn());
  if (strand_.IsDeleted() || job.cancelled->load()) return absl::OkStatus();
  if (const auto* query = std::get_if<QueryJob>(&job.work)) {
    return CommitQuery(*query, std::get<VerifyOverlapResult>(result));
  }
  if (const auto* fuse = std::get_if<FuseJob>(&job.work)) {
    return CommitFuse(*fuse, std::get<FuseMapsResult>(result));
  }
  return CommitAdjust(std::get<AdjustJob>(job.work), std::get<AdjustBundleResult>(result));
}

absl::Status FusionCoordinator::CommitQuery(const QueryJob& job,
                                            const VerifyOverlapResult& result) {
  const QueryRecord record{job.task, result.overlaps, strand_.environment().clock()};
  RETURN_IF_ERROR(strand_.Append(record));
  // The tables of poses that it needs are made while others may read.
  strand_.WithState([&record](const MissionState& state) { PrepareToApply(record, state); });
  StateWriteLock lock(strand_);
  map_store::Apply(record, strand_.options(), strand_.mutable_state());
  return absl::OkStatus();
}

absl::Status FusionCoordinator::CommitRefusedFuse(const FuseJob& job,
                                                  const FuseMapsResult& result) {
  const FuseRefusedRecord record{job.action.target, job.new_overlaps, job.relaxed,
                                 result.worst_edge_chi2};
  RETURN_IF_ERROR(strand_.Append(record));
  StateWriteLock lock(strand_);
  map_store::Apply(record, strand_.mutable_state());
  if (!job.relaxed.empty()) lanes_.CancelAdjustment(job.action);
  return absl::OkStatus();
}

absl::Status FusionCoordinator::CommitFuse(const FuseJob& job, const FuseMapsResult& result) {
  if (!result.accepted) return CommitRefusedFuse(job, result);
  FuseRecord record;
  record.relaxed = job.relaxed;
  // Only writers change what the plan is made of, and this one has the turn.
  record.plan = PlanFuse(strand_.state_in_turn(), job, result);
  {
    absl::ReaderMutexLock lock(&strand_.mutex());
    record.merge_ms = SinceVerified(record.plan.overlaps);
  }
  // Where all was adjusted since, poses from before would undo that; fusing the same anew does not.
  // After an urgent fusing all is adjusted again.
  if (IsOvertaken(job, record)) return absl::OkStatus();
  RETURN_IF_ERROR(strand_.Append(record));
  // The layers are given up after the lock: freeing them takes time, too.
  RevisionLayers layers = PrepareLayers(record.plan, strand_.options(), strand_.state_in_turn());
  StateWriteLock lock(strand_);
  const bool urgent = map_store::Apply(record, layers, strand_.mutable_state());
  if (urgent) lanes_.CancelAdjustment(job.action);
  return absl::OkStatus();
}

bool FusionCoordinator::IsOvertaken(const FuseJob& job, const FuseRecord& record) const {
  absl::ReaderMutexLock lock(&strand_.mutex());
  return !IsUrgent(record, strand_.state()) &&
         WasPlacedSince(job.request.base_revision, record.plan, strand_.state().global);
}

double FusionCoordinator::SinceVerified(const std::vector<uint64_t>& overlaps) const {
  absl::Time first = absl::InfiniteFuture();
  for (const uint64_t id : overlaps) {
    first = std::min(first, strand_.state().global.overlaps.at(id).verified_at);
  }
  return overlaps.empty() ? 0 : absl::ToDoubleMilliseconds(strand_.environment().clock() - first);
}

absl::Status FusionCoordinator::CommitAdjust(const AdjustJob& job,
                                             const AdjustBundleResult& result) {
  AdjustRecord record;
  record.plan = PlanAdjust(strand_.state_in_turn(), job, result);
  {
    absl::ReaderMutexLock lock(&strand_.mutex());
    const MissionState& state = strand_.state();
    const auto it = state.global.islands.find(job.snapshot.island);
    if (it == state.global.islands.end()) return absl::OkStatus();
    if (it->second.generation != job.snapshot.generation) return absl::OkStatus();
    // The island stays dirty if something arrived or was welded while the worker was busy: it waits
    // for the next adjustment.
    record.dirty = it->second.version_of_owners > job.snapshot.version_of_owners ||
                   WasPlacedSince(job.request.base_revision, record.plan, state.global);
  }
  record.statistics = {result.keyframes, result.points, result.iterations, result.seconds * 1e3};
  RETURN_IF_ERROR(strand_.Append(record));
  RevisionLayers layers = PrepareLayers(record.plan, strand_.options(), strand_.state_in_turn());
  StateWriteLock lock(strand_);
  map_store::Apply(record, layers, strand_.mutable_state());
  lanes_.ForgetTrouble(record.plan.target);
  return absl::OkStatus();
}

void FusionCoordinator::NoteFailure(const FusionJob& job, const absl::Status& status) {
  if (strand_.deleted()) return;
  ++strand_.mutable_state().statistics.failed_requests;
  if (const auto* query = std::get_if<QueryJob>(&job.work)) return NoteFailedQuery(*query);
  if (const auto* fuse = std::get_if<FuseJob>(&job.work)) return NoteFailedFuse(*fuse, status);
  NoteFailedAdjust(std::get<AdjustJob>(job.work));
}

void FusionCoordinator::NoteFailedQuery(const QueryJob& job) {
  MissionState& state = strand_.mutable_state();
  if (state.queries.CountFailureOfFront() < strand_.options().max_attempts) return;
  ++state.failed_queries[{job.task.query.local_map, job.task.against}];
  state.queries.PopFront();
}

void FusionCoordinator::NoteFailedFuse(const FuseJob& job, const absl::Status& status) {
  MissionState& state = strand_.mutable_state();
  for (const uint64_t id : job.action.overlaps) {
    state.global.overlaps.Change(id, [&](OverlapEntry& entry) {
      if (++entry.attempts < strand_.options().max_attempts) return;
      Refuse(absl::StrCat("worker failed: ", status.message()), OverlapState::kFailed, entry);
    });
  }
  const auto island = state.global.islands.find(job.action.target);
  if (island != state.global.islands.end()) LeaveToAdjustment(job.relaxed, state, island->second);
}

void FusionCoordinator::NoteFailedAdjust(const AdjustJob& job) {
  MissionState& state = strand_.mutable_state();
  const IslandId id = job.snapshot.island;
  const auto island = state.global.islands.find(id);
  const int failed = lanes_.NoteFailedAdjustment(id);
  if (failed < strand_.options().max_attempts || island == state.global.islands.end()) return;
  lanes_.ForgetTrouble(id);
  GiveUpAdjustment(state, island->second);
}

}  // namespace corbslam::map_store
