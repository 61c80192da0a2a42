// Says what becomes of fusion work that had nothing to do, has a result, or failed.
#include <algorithm>

#include "absl/strings/str_cat.h"
#include "map_store/coordination/fusion_coordinator.h"
#include "map_store/coordination/fusion_events.h"
#include "map_store/fusion/overlap_units.h"
#include "map_store/fusion/revision.h"
#include "map_store/mission/pausing_read.h"
#include "map_store/records/record_application.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// An adjustment is drafted so often while others commit.
constexpr int kMaxDrafts = 3;

// Returns whether something that the plan places was placed after `revision`.
bool WasPlacedSince(uint64_t revision, const RevisionPlan& plan, const GlobalLayer& global) {
  return std::ranges::any_of(plan.keyframes, [&](const auto& planned) {
    const auto it = global.keyframes.find(planned.first);
    return it != global.keyframes.end() && it->second.revision > revision;
  });
}

// Drafts what an adjustment makes of the state.
absl::StatusOr<AdjustmentDraft> Draft(const MissionState& state, const MapStoreOptions& options,
                                      const AdjustJob& job, const AdjustBundleResult& result,
                                      LongRead& read) {
  AdjustmentDraft draft;
  ASSIGN_OR_RETURN(draft.record.plan, PlanAdjust(state, job, result, read));
  draft.record.dirty = WasPlacedSince(job.request.base_revision, draft.record.plan, state.global);
  draft.record.statistics = {result.keyframes, result.points, result.iterations,
                             result.seconds * 1e3};
  ASSIGN_OR_RETURN(draft.layers, PrepareLayers(draft.record.plan, options, state, read));
  return draft;
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
  if (const auto* adjust = std::get_if<AdjustJob>(&job.work)) {
    return CommitAdjust(*adjust, std::get<AdjustBundleResult>(result), *job.cancelled);
  }
  // The old layers are given up behind the turn: freeing them takes time, too.
  RevisionLayers layers;
  absl::MutexLock turn(&strand_.turn());
  if (strand_.IsDeleted() || job.cancelled->load()) return absl::OkStatus();
  if (const auto* query = std::get_if<QueryJob>(&job.work)) {
    return CommitQuery(*query, std::get<VerifyOverlapResult>(result));
  }
  return CommitFuse(std::get<FuseJob>(job.work), std::get<FuseMapsResult>(result), layers);
}

absl::Status FusionCoordinator::CommitQuery(const QueryJob& job,
                                            const VerifyOverlapResult& result) {
  QueryRecord record{job.task, result.overlaps, strand_.environment().clock()};
  // Merges wait for this: islands' units are those of the worker's views still.
  strand_.WithState([&record](const MissionState& state) {
    for (Overlap& overlap : record.overlaps) ToOwnersUnits(state, overlap);
  });
  RETURN_IF_ERROR(strand_.Append(record));
  // The tables of poses that it needs are made while others may read.
  strand_.WithState([&record](const MissionState& state) { PrepareToApply(record, state); });
  uint64_t first = 0;
  {
    StateWriteLock lock(strand_);
    first = strand_.state().next_overlap;
    map_store::Apply(record, strand_.options(), strand_.mutable_state());
  }
  for (const MissionEvent::OverlapAccepted& accepted : strand_.WithState(
           [first](const MissionState& state) { return ListAcceptedFrom(first, state); })) {
    NoteEvent(accepted);
  }
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

absl::Status FusionCoordinator::CommitFuse(const FuseJob& job, const FuseMapsResult& result,
                                           RevisionLayers& layers) {
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
  layers = PrepareLayers(record.plan, strand_.options(), strand_.state_in_turn());
  {
    StateWriteLock lock(strand_);
    const bool urgent = map_store::Apply(record, layers, strand_.mutable_state());
    if (urgent) lanes_.CancelAdjustment(job.action);
  }
  NoteEvent(strand_.WithState(
      [&record](const MissionState& state) { return DescribeFusing(record, state); }));
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

absl::Status FusionCoordinator::CommitAdjust(const AdjustJob& job, const AdjustBundleResult& result,
                                             const std::atomic<bool>& cancelled) {
  for (int draft = 0; draft < kMaxDrafts; ++draft) {
    absl::StatusOr<AdjustmentDraft> drafted = DraftAdjustment(job, result, cancelled);
    if (!drafted.ok()) continue;
    absl::MutexLock turn(&strand_.turn());
    if (!IsWanted(job, cancelled)) return absl::OkStatus();
    const MissionState& state = strand_.state_in_turn();
    if (state.global.revision + 1 != drafted->record.plan.revision) continue;
    if (!RefreshLayers(drafted->record.plan, strand_.options(), state, drafted->layers)) continue;
    return CommitDraft(job, *drafted);
  }
  // Others go on committing: this one is drafted while they wait.
  absl::StatusOr<AdjustmentDraft> draft;
  absl::MutexLock turn(&strand_.turn());
  if (!IsWanted(job, cancelled)) return absl::OkStatus();
  UnbrokenRead read;
  draft = Draft(strand_.state_in_turn(), strand_.options(), job, result, read);
  return draft.ok() ? CommitDraft(job, *draft) : draft.status();
}

bool FusionCoordinator::IsWanted(const AdjustJob& job, const std::atomic<bool>& cancelled) const {
  if (strand_.IsDeleted() || cancelled.load()) return false;
  absl::ReaderMutexLock lock(&strand_.mutex());
  const auto& islands = strand_.state().global.islands;
  const auto it = islands.find(job.snapshot.island);
  return it != islands.end() && it->second.generation == job.snapshot.generation;
}

absl::StatusOr<AdjustmentDraft> FusionCoordinator::DraftAdjustment(
    const AdjustJob& job, const AdjustBundleResult& result,
    const std::atomic<bool>& cancelled) const {
  absl::StatusOr<AdjustmentDraft> draft;
  {
    absl::ReaderMutexLock lock(&strand_.mutex());
    if (!strand_.state().global.islands.contains(job.snapshot.island)) {
      return absl::AbortedError("the island has gone");
    }
    PausingRead read(strand_, GoesOnUntilRevised(cancelled));
    draft = Draft(strand_.state(), strand_.options(), job, result, read);
  }
  if (draft.ok()) strand_.environment().journal->Prepare(draft->record);
  return draft;
}

absl::Status FusionCoordinator::CommitDraft(const AdjustJob& job, AdjustmentDraft& draft) {
  {
    absl::ReaderMutexLock lock(&strand_.mutex());
    const Island& island = strand_.state().global.islands.at(job.snapshot.island);
    // The island stays dirty if something arrived while the worker was busy: it waits for the next
    // adjustment.
    draft.record.dirty =
        draft.record.dirty || island.version_of_owners > job.snapshot.version_of_owners;
  }
  RETURN_IF_ERROR(strand_.Append(draft.record));
  {
    StateWriteLock lock(strand_);
    map_store::Apply(draft.record, draft.layers, strand_.mutable_state());
    lanes_.ForgetTrouble(draft.record.plan.target);
  }
  NoteEvent(DescribeAdjustment(draft.record, strand_.environment().clock() - job.begin));
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
