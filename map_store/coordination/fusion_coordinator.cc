#include "map_store/coordination/fusion_coordinator.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/coordination/scale_contradictions.h"
#include "map_store/fusion/overlap_vagueness.h"
#include "map_store/fusion/query_choice.h"
#include "map_store/mission/pausing_read.h"
#include "map_store/records/record_application.h"
#include "map_store/records/retraction.h"
#include "map_store/view/metres.h"
#include "slam/exchange/agent_report.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// One piece of work is interrupted at most so often while its views are read; others commit far
// more seldom than that.
constexpr int kMaxInterruptions = 20;

FusionSummary::IslandSummary SummariseIsland(const MissionState& state, const Island& island) {
  FusionSummary::IslandSummary summary;
  summary.in_metres = IsInMetres(state, island);
  summary.id = island.id;
  summary.order = state.FindLocalMap(island.local_maps.front())->order;
  summary.keyframes = CountKeyframes(state, island);
  summary.fused = island.fused;
  summary.quiet = IsQuiet(state, island);
  summary.dirty = island.dirty;
  summary.needs_adjustment = island.needs_adjustment;
  summary.overlaps_since_adjustment = island.overlaps_since_adjustment;
  summary.new_keyframes = summary.keyframes - std::min(island.adjusted, summary.keyframes);
  summary.displaced = island.displaced.size();
  summary.moved = island.moved.size();
  summary.relaxed = island.relaxed.size();
  return summary;
}

bool PlacesVaguely(const Overlap& overlap, const MissionState& state) {
  const LocalMapState* local_map = state.FindLocalMap(overlap.candidate.local_map);
  return local_map != nullptr && IsVague(overlap, local_map->map);
}

}  // namespace

FusionCoordinator::FusionCoordinator(MissionStrand& strand, EventBook& events,
                                     std::function<void()> notify)
    : strand_(strand), events_(events), notify_(std::move(notify)) {}

FusionSummary FusionCoordinator::Summarise() const {
  const MissionState& state = strand_.state();
  FusionSummary summary;
  for (const auto& [id, island] : state.global.islands) {
    FusionSummary::IslandSummary& added =
        summary.islands.emplace_back(SummariseIsland(state, island));
    added.adjusting = lanes_.IsAdjusting(id);
    added.cancelled_adjustments = lanes_.CountCancelled(id);
  }
  std::sort(summary.islands.begin(), summary.islands.end(),
            [](const auto& a, const auto& b) { return a.order < b.order; });
  for (const uint64_t id : state.global.overlaps.waiting()) {
    const OverlapEntry& entry = state.global.overlaps.at(id);
    const IslandId a = state.global.island_of.at(entry.overlap.query.local_map);
    const IslandId b = state.global.island_of.at(entry.overlap.candidate.local_map);
    const bool is_vague = a != b && PlacesVaguely(entry.overlap, state);
    summary.waiting.push_back({id, a, b, entry.urgent, entry.alone, is_vague});
  }
  summary.queries = state.queries.size();
  summary.graph_lane_busy = lanes_.IsBusy(FusionLane::kGraph);
  summary.adjustment_lane_busy = lanes_.IsBusy(FusionLane::kAdjustment);
  return summary;
}

PolicyLimits FusionCoordinator::Limits() const {
  PolicyLimits limits;
  limits.weld_every = strand_.options().weld_every;
  limits.weld_share = strand_.options().weld_share;
  limits.adjust_share = strand_.options().adjust_share;
  limits.adjust_min_keyframes = strand_.options().adjust_min_keyframes;
  return limits;
}

std::optional<FusionAction> FusionCoordinator::NextAction(FusionLane lane) const {
  if (strand_.deleted() || !strand_.environment().has_worker) return std::nullopt;
  if (strand_.IsDamaged()) return std::nullopt;
  for (const FusionAction& action : DecideActions(Summarise(), Limits())) {
    if (LaneOf(action) == lane) return action;
  }
  return std::nullopt;
}

std::optional<FusionJob> FusionCoordinator::StartJob(FusionLane lane) {
  bool skipped = false;
  int interruptions = 0;
  Started started = TryStart(lane);
  while (started.attempt == Attempt::kSkipped || started.attempt == Attempt::kInterrupted) {
    interruptions = started.attempt == Attempt::kSkipped ? 0 : interruptions + 1;
    // It is the other missions' turn; this one is woken again.
    if (interruptions == kMaxInterruptions) break;
    skipped = true;
    started = TryStart(lane);
  }
  // A skipped action may have been all that the other lane waited for.
  if (skipped) strand_.environment().wake_fusion();
  return std::move(started.job);
}

FusionCoordinator::Started FusionCoordinator::TryStart(FusionLane lane) {
  const std::optional<Claim> claim = ClaimLane(lane);
  if (!claim.has_value()) return {};
  if (claim->chooses_queried_maps) {
    const Attempt attempt = Choose(*claim);
    ReleaseLane(lane);
    return {attempt, std::nullopt};
  }
  const absl::Time begin = strand_.environment().clock();
  absl::StatusOr<std::optional<FusionRequest>> request = Prepare(*claim);
  if (request.ok() && request->has_value()) {
    if (auto* adjust = std::get_if<AdjustJob>(&**request)) adjust->begin = begin;
    return {Attempt::kStarted, FusionJob{**std::move(request), claim->cancelled}};
  }
  if (request.ok()) {
    StateWriteLock lock(strand_);
    if (!claim->cancelled->load()) SkipAction(claim->action);
  }
  ReleaseLane(lane);
  return {request.ok() ? Attempt::kSkipped : Attempt::kInterrupted, std::nullopt};
}

std::optional<FusionCoordinator::Claim> FusionCoordinator::ClaimLane(FusionLane lane) {
  StateWriteLock lock(strand_);
  if (lanes_.IsBusy(lane)) return std::nullopt;
  const std::optional<FusionAction> action = NextAction(lane);
  if (!action.has_value()) {
    if (lane == FusionLane::kGraph) query_views_.Clear();
    lane_released_.SignalAll();
    return std::nullopt;
  }
  const bool chooses_queried_maps =
      action->kind == FusionAction::Kind::kQuery && !strand_.state().queries.IsFrontChosen();
  return Claim{*action, lanes_.Claim(*action), chooses_queried_maps};
}

FusionCoordinator::Attempt FusionCoordinator::Choose(const Claim& claim) {
  // In lockstep nothing waits long, and the order is that of arrival.
  if (!strand_.options().deterministic) {
    StateWriteLock lock(strand_);
    MissionState& state = strand_.mutable_state();
    if (!claim.cancelled->load()) state.queries.BringForward(ChooseNextToQuery(state));
  }
  absl::StatusOr<std::vector<LocalMapId>> against;
  {
    absl::ReaderMutexLock lock(&strand_.mutex());
    PausingRead read(strand_, GoesOnUntilRevised(*claim.cancelled));
    against = ChooseQueriedMaps(strand_.state(), strand_.options(), read);
  }
  if (!against.ok()) return Attempt::kInterrupted;
  StateWriteLock lock(strand_);
  if (!claim.cancelled->load()) strand_.mutable_state().queries.ChooseOfFront(*against);
  return Attempt::kSkipped;
}

std::function<absl::Status()> FusionCoordinator::GoesOnUntilRevised(
    const std::atomic<bool>& cancelled) const {
  const uint64_t revision = strand_.state().global.revision;
  return [this, &cancelled, revision]() ABSL_SHARED_LOCKS_REQUIRED(strand_.mutex()) {
    if (cancelled.load()) return absl::AbortedError("cancelled");
    if (strand_.state().global.revision == revision) return absl::OkStatus();
    return absl::AbortedError("another revision was committed");
  };
}

absl::StatusOr<std::optional<FusionRequest>> FusionCoordinator::Prepare(const Claim& claim) {
  absl::ReaderMutexLock lock(&strand_.mutex());
  PausingRead read(strand_, GoesOnUntilRevised(*claim.cancelled));
  return PrepareRequest(strand_.state(), claim.action, strand_.options(), read, query_views_);
}

void FusionCoordinator::ReleaseLane(FusionLane lane) {
  StateWriteLock lock(strand_);
  lanes_.Release(lane);
  lane_released_.SignalAll();
}

JobEnd FusionCoordinator::FinishJob(FusionLane lane, FusionJob job,
                                    absl::StatusOr<FusionResult> result) {
  absl::Status status = result.status();
  const bool may_wait = !strand_.options().deterministic;
  if (result.ok()) {
    status = Commit(job, *result);
    // Only the journal can have refused: nothing is wrong with the work.
    if (!status.ok() && may_wait) return KeepRefused(lane, std::move(job), *std::move(result));
  }
  const bool try_later = may_wait && absl::IsUnavailable(status);
  if (!status.ok() && !try_later) {
    StateWriteLock lock(strand_);
    if (!job.cancelled->load()) NoteFailure(job, status);
  }
  ReleaseLane(lane);
  if (status.ok()) TellOthers();
  return try_later ? JobEnd::kTryLater : JobEnd::kDone;
}

JobEnd FusionCoordinator::KeepRefused(FusionLane lane, FusionJob job, FusionResult result) {
  if (strand_.IsDamaged()) {
    ReleaseLane(lane);
    return JobEnd::kDone;
  }
  const absl::Time next_try =
      strand_.environment().clock() + absl::Milliseconds(strand_.options().retry_ms);
  absl::MutexLock lock(&refused_mutex_);
  refused_[static_cast<size_t>(lane)] = Refused{std::move(job), std::move(result), next_try};
  return JobEnd::kRefused;
}

std::optional<JobEnd> FusionCoordinator::RetryCommit(FusionLane lane) {
  std::optional<Refused> refused;
  {
    absl::MutexLock lock(&refused_mutex_);
    std::optional<Refused>& kept = refused_[static_cast<size_t>(lane)];
    if (!kept.has_value()) return std::nullopt;
    if (strand_.environment().clock() < kept->next_try) return JobEnd::kRefused;
    refused.swap(kept);
  }
  return FinishJob(lane, std::move(refused->job), std::move(refused->result));
}

void FusionCoordinator::CancelJobs() {
  StateWriteLock lock(strand_);
  lanes_.CancelAll();
}

void FusionCoordinator::Stop() {
  StateWriteLock lock(strand_);
  strand_.mutable_state().queries.Clear();
  lanes_.CancelAll();
  lane_released_.SignalAll();
}

// The jobs are cancelled under the same lock that changes what they began with, lest another begins
// between.
absl::Status FusionCoordinator::CommitDecision(const JournalRecord& record,
                                               absl::FunctionRef<void(MissionState&)> apply) {
  RETURN_IF_ERROR(strand_.Append(record));
  StateWriteLock lock(strand_);
  lanes_.CancelAll();
  apply(strand_.mutable_state());
  lanes_.ForgetTrouble();
  return absl::OkStatus();
}

absl::Status FusionCoordinator::TellOfDecision() {
  RETURN_IF_ERROR(strand_.Sync());
  strand_.environment().wake_fusion();
  TellOthers();
  return absl::OkStatus();
}

void FusionCoordinator::TellOthers() {
  notify_();
  events_.Tell();
}

void FusionCoordinator::NoteEvent(MissionEvent::What what) {
  events_.Note(strand_.state_in_turn().global.revision, std::move(what));
}

absl::Status FusionCoordinator::Rederive() {
  {
    absl::MutexLock turn(&strand_.turn());
    if (strand_.IsDeleted()) return strand_.SayDeleted();
    const RederiveRecord record;
    RETURN_IF_ERROR(CommitDecision(
        record, [&record](MissionState& state) { map_store::Apply(record, state); }));
    NoteEvent(MissionEvent::GlobalLayerForgotten{});
  }
  return TellOfDecision();
}

absl::StatusOr<std::vector<uint64_t>> FusionCoordinator::RetractOverlap(uint64_t overlap,
                                                                        bool keep_apart) {
  std::vector<uint64_t> taken_back;
  {
    absl::MutexLock turn(&strand_.turn());
    if (strand_.IsDeleted()) return strand_.SayDeleted();
    const RetractRecord record{overlap, keep_apart};
    RETURN_IF_ERROR(strand_.WithState(
        [&record](const MissionState& state) { return CheckRetraction(state, record); }));
    RETURN_IF_ERROR(CommitDecision(record, [&](MissionState& state) {
      taken_back = Retract(record, strand_.options(), state);
    }));
    NoteEvent(MissionEvent::OverlapsTakenBack{taken_back});
  }
  RETURN_IF_ERROR(TellOfDecision());
  return taken_back;
}

void FusionCoordinator::KeepApart(const std::string& agent,
                                  const std::vector<MapContradiction>& contradictions) {
  if (contradictions.empty()) return;
  const std::vector<ContradictedOverlap> found = strand_.WithState(
      [&](const MissionState& state) { return FindContradicted(state, agent, contradictions); });
  for (const ContradictedOverlap& contradicted : found) {
    const auto taken_back = RetractOverlap(contradicted.overlap, /*keep_apart=*/true);
    LOG(WARNING) << "mission " << strand_.name() << ": agent " << agent
                 << " measures that local map " << ToString(contradicted.others) << " is "
                 << contradicted.scale << " times as large as what its camera sees: its local map "
                 << ToString(contradicted.own)
                 << (taken_back.ok() ? " is kept apart from it"
                                     : absl::StrCat(" can't be kept apart from it: ",
                                                    taken_back.status().ToString()));
  }
}

FusionRequestCounts FusionCoordinator::CountWaiting() const {
  absl::ReaderMutexLock lock(&strand_.mutex());
  if (strand_.deleted() || !strand_.environment().has_worker) return {};
  FusionRequestCounts counts = CountRequests(Summarise(), Limits());
  for (const FusionLane lane : kFusionLanes) {
    // The state still asks for what runs until that is committed.
    if (const auto kind = lanes_.Running(lane)) TakeOne(*kind, counts);
  }
  return counts;
}

bool FusionCoordinator::RestsLocked(bool but_for_look_ups) const {
  return std::ranges::all_of(
      kFusionLanes, [&](FusionLane lane) ABSL_SHARED_LOCKS_REQUIRED(strand_.mutex()) {
        if (lanes_.IsBusy(lane)) return false;
        const std::optional<FusionAction> next = NextAction(lane);
        return !next.has_value() || (but_for_look_ups && next->kind == FusionAction::Kind::kQuery);
      });
}

bool FusionCoordinator::RestsButForQueries() const {
  absl::ReaderMutexLock lock(&strand_.mutex());
  return RestsLocked(/*but_for_look_ups=*/true);
}

bool FusionCoordinator::IsIdleLocked() const { return RestsLocked(/*but_for_look_ups=*/false); }

bool FusionCoordinator::IsIdle() const {
  absl::ReaderMutexLock lock(&strand_.mutex());
  return IsIdleLocked();
}

bool FusionCoordinator::HasWork() const {
  absl::ReaderMutexLock lock(&strand_.mutex());
  return !DecideActions(Summarise(), Limits()).empty();
}

bool FusionCoordinator::WaitUntilIdle(absl::Time deadline) const {
  absl::MutexLock lock(&strand_.mutex());
  while (!IsIdleLocked()) {
    if (lane_released_.WaitWithDeadline(&strand_.mutex(), deadline)) return IsIdleLocked();
  }
  return true;
}

}  // namespace corbslam::map_store
