// Mission's fusion lanes: what to do next, and what to do with results.
#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/mission.h"
#include "map_store/record_application.h"
#include "map_store/retraction.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Of one piece of work while its views are read: others commit far more seldom than that.
constexpr int kMaxInterruptions = 20;

// The caller holds it for reading. A writer that waits comes first.
void LetWritersIn(absl::Mutex& mutex) ABSL_NO_THREAD_SAFETY_ANALYSIS {
  mutex.ReaderUnlock();
  mutex.ReaderLock();
}

FusionLane LaneOf(const FusionAction& action) {
  return action.kind == FusionAction::Kind::kAdjust ? FusionLane::kAdjustment : FusionLane::kGraph;
}

FusionSummary::IslandSummary SummariseIsland(const MissionState& state, const Island& island) {
  FusionSummary::IslandSummary summary;
  summary.id = island.id;
  summary.order = state.FindLocalMap(island.local_maps.front())->order;
  for (const LocalMapId& id : island.local_maps) {
    summary.keyframes += state.FindLocalMap(id)->map.keyframes().size();
  }
  summary.fused = island.fused;
  summary.quiet = IsQuiet(state, island);
  summary.dirty = island.dirty;
  summary.needs_adjustment = island.needs_adjustment;
  summary.overlaps_since_adjustment = island.overlaps_since_adjustment;
  summary.displaced = island.displaced.size();
  summary.relaxed = island.relaxed.size();
  return summary;
}

// Something that the plan places.
bool WasPlacedSince(uint64_t revision, const RevisionPlan& plan, const GlobalLayer& global) {
  return std::ranges::any_of(plan.keyframes, [&](const auto& planned) {
    const auto it = global.keyframes.find(planned.first);
    return it != global.keyframes.end() && it->second.revision > revision;
  });
}

void GiveUpAdjustment(Island& island) {
  island.needs_adjustment = false;
  island.dirty = false;
  island.overlaps_since_adjustment = 0;
  island.displaced.clear();
}

}  // namespace

// Made, used and given up under the state's lock, held for reading.
class Mission::PausingRead : public LongRead {
 public:
  PausingRead(const Mission& mission, const std::atomic<bool>& cancelled)
      ABSL_SHARED_LOCKS_REQUIRED(mission.mutex_)
      : mission_(mission), cancelled_(cancelled), revision_(mission.state_.global.revision) {}

  absl::Status Pause() override ABSL_NO_THREAD_SAFETY_ANALYSIS {
    LetWritersIn(mission_.mutex_);
    if (cancelled_.load()) return absl::AbortedError("cancelled");
    if (mission_.state_.global.revision == revision_) return absl::OkStatus();
    return absl::AbortedError("another revision was committed");
  }

 private:
  const Mission& mission_;
  const std::atomic<bool>& cancelled_;
  const uint64_t revision_;
};

FusionSummary Mission::Summarise() const {
  FusionSummary summary;
  const Lane& adjustment = lanes_[static_cast<size_t>(FusionLane::kAdjustment)];
  for (const auto& [id, island] : state_.global.islands) {
    FusionSummary::IslandSummary& added =
        summary.islands.emplace_back(SummariseIsland(state_, island));
    added.adjusting = adjustment.busy && adjustment.target == id && !adjustment.cancelled->load();
    const auto trouble = adjustment_trouble_.find(id);
    if (trouble != adjustment_trouble_.end()) {
      added.cancelled_adjustments = trouble->second.cancelled;
    }
  }
  std::sort(summary.islands.begin(), summary.islands.end(),
            [](const auto& a, const auto& b) { return a.order < b.order; });
  for (const auto& [id, entry] : state_.global.overlaps) {
    if (entry.state != OverlapState::kWaiting) continue;
    const LocalMapId a = entry.overlap.query.local_map;
    const LocalMapId b = entry.overlap.candidate.local_map;
    summary.waiting.push_back({id, state_.global.island_of.at(a), state_.global.island_of.at(b),
                               entry.urgent, entry.alone});
  }
  summary.queries = state_.queries.size();
  summary.graph_lane_busy = lanes_[static_cast<size_t>(FusionLane::kGraph)].busy;
  summary.adjustment_lane_busy = adjustment.busy;
  return summary;
}

PolicyLimits Mission::Limits() const {
  PolicyLimits limits;
  limits.weld_every = environment_.options->weld_every;
  limits.adjust_every = environment_.options->adjust_every;
  return limits;
}

std::optional<FusionAction> Mission::NextAction(FusionLane lane) const {
  if (deleted_ || !environment_.has_worker) return std::nullopt;
  for (const FusionAction& action : DecideActions(Summarise(), Limits())) {
    if (LaneOf(action) == lane) return action;
  }
  return std::nullopt;
}

std::optional<FusionJob> Mission::StartJob(FusionLane lane_id) {
  bool skipped = false;
  int interruptions = 0;
  std::optional<FusionJob> job;
  while (TryStart(lane_id, interruptions, job)) skipped = true;
  // What was skipped may have been all that the other lane waited for.
  if (skipped) environment_.wake_fusion();
  return job;
}

std::optional<FusionAction> Mission::ClaimLane(FusionLane lane_id,
                                               std::shared_ptr<std::atomic<bool>>& cancelled) {
  absl::MutexLock lock(&mutex_);
  Lane& lane = lanes_[static_cast<size_t>(lane_id)];
  if (lane.busy) return std::nullopt;
  const std::optional<FusionAction> action = NextAction(lane_id);
  if (!action.has_value()) {
    lane_released_.SignalAll();
    return std::nullopt;
  }
  lane.busy = true;
  lane.kind = action->kind;
  lane.target = action->target;
  lane.cancelled = cancelled = std::make_shared<std::atomic<bool>>(false);
  return action;
}

absl::StatusOr<std::optional<FusionRequest>> Mission::Prepare(
    const FusionAction& action, const std::atomic<bool>& cancelled) const {
  absl::ReaderMutexLock lock(&mutex_);
  PausingRead read(*this, cancelled);
  return PrepareRequest(state_, action, *environment_.options, read);
}

bool Mission::TryStart(FusionLane lane, int& interruptions, std::optional<FusionJob>& job) {
  std::shared_ptr<std::atomic<bool>> cancelled;
  const std::optional<FusionAction> action = ClaimLane(lane, cancelled);
  if (!action.has_value()) return false;
  absl::StatusOr<std::optional<FusionRequest>> request = Prepare(*action, *cancelled);
  if (request.ok() && request->has_value()) {
    job = FusionJob{**std::move(request), std::move(cancelled)};
    return false;
  }
  interruptions = request.ok() ? 0 : interruptions + 1;
  if (request.ok()) {
    absl::MutexLock lock(&mutex_);
    if (!cancelled->load()) SkipAction(*action);
  }
  ReleaseLane(lane);
  // The other missions' turn; this one is woken again.
  return interruptions < kMaxInterruptions;
}

void Mission::SkipAction(const FusionAction& action) {
  if (action.kind == FusionAction::Kind::kQuery) {
    state_.queries.pop_front();
    return;
  }
  if (action.kind == FusionAction::Kind::kAdjust) {
    const auto island = state_.global.islands.find(action.target);
    if (island != state_.global.islands.end()) GiveUpAdjustment(island->second);
    return;
  }
  for (const uint64_t id : action.overlaps) {
    Refuse("its keyframes were removed", OverlapState::kFailed, state_.global.overlaps.at(id));
  }
  Island& island = state_.global.islands.at(action.target);
  const std::vector<LocalMapId> relaxed(island.relaxed.begin(), island.relaxed.end());
  LeaveToAdjustment(relaxed, state_, island);
}

bool Mission::FinishJob(FusionLane lane, const FusionJob& job,
                        absl::StatusOr<FusionResult> result) {
  absl::Status status = result.status();
  bool try_later = absl::IsUnavailable(status);
  if (result.ok()) {
    status = Commit(job, *result);
    // Only the journal can refuse: nothing is wrong with the work.
    try_later = !status.ok();
  }
  try_later = try_later && !environment_.options->deterministic;
  if (!status.ok() && !try_later) {
    absl::MutexLock lock(&mutex_);
    if (!job.cancelled->load()) NoteFailure(job, status);
  }
  ReleaseLane(lane);
  if (status.ok()) NotifyAll(0);
  return !try_later;
}

void Mission::ReleaseLane(FusionLane lane_id) {
  absl::MutexLock lock(&mutex_);
  Lane& lane = lanes_[static_cast<size_t>(lane_id)];
  lane.busy = false;
  lane.cancelled.reset();
  lane_released_.SignalAll();
}

absl::Status Mission::Rederive() {
  {
    absl::MutexLock turn(&writer_mutex_);
    if (IsDeleted()) return Deleted();
    const RederiveRecord record;
    RETURN_IF_ERROR(Append(record));
    absl::MutexLock lock(&mutex_);
    CancelJobsLocked();
    map_store::Apply(record, state_);
    adjustment_trouble_.clear();
  }
  RETURN_IF_ERROR(SyncJournal());
  environment_.wake_fusion();
  NotifyAll(0);
  return absl::OkStatus();
}

absl::StatusOr<std::vector<uint64_t>> Mission::RetractOverlap(uint64_t overlap, bool keep_apart) {
  std::vector<uint64_t> taken_back;
  {
    absl::MutexLock turn(&writer_mutex_);
    if (IsDeleted()) return Deleted();
    RETURN_IF_ERROR(WithState(
        [overlap](const MissionState& state) { return CheckRetractable(state, overlap); }));
    const RetractRecord record{overlap, keep_apart};
    RETURN_IF_ERROR(Append(record));
    absl::MutexLock lock(&mutex_);
    CancelJobsLocked();
    taken_back = Retract(record, *environment_.options, state_);
    adjustment_trouble_.clear();
  }
  RETURN_IF_ERROR(SyncJournal());
  environment_.wake_fusion();
  NotifyAll(0);
  return taken_back;
}

void Mission::CancelJobs() {
  absl::MutexLock lock(&mutex_);
  CancelJobsLocked();
}

// Whoever changes what the jobs began with does so under the same lock, lest another begins
// between.
void Mission::CancelJobsLocked() {
  for (Lane& lane : lanes_) {
    if (lane.cancelled != nullptr) lane.cancelled->store(true);
  }
}

bool Mission::IsIdleLocked() const {
  for (const Lane& lane : lanes_) {
    if (lane.busy) return false;
  }
  return !NextAction(FusionLane::kGraph).has_value() &&
         !NextAction(FusionLane::kAdjustment).has_value();
}

bool Mission::IsFusionIdle() const {
  absl::ReaderMutexLock lock(&mutex_);
  return IsIdleLocked();
}

bool Mission::WaitUntilFusionIdle(absl::Time deadline) const {
  absl::MutexLock lock(&mutex_);
  while (!IsIdleLocked()) {
    if (lane_released_.WaitWithDeadline(&mutex_, deadline)) return IsIdleLocked();
  }
  return true;
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
    if (++state_.queries.front().attempts >= max_attempts) state_.queries.pop_front();
    return;
  }
  if (const auto* fuse = std::get_if<FuseJob>(&job.work)) {
    for (const uint64_t id : fuse->action.overlaps) {
      OverlapEntry& entry = state_.global.overlaps.at(id);
      if (++entry.attempts < max_attempts) continue;
      Refuse(absl::StrCat("worker failed: ", status.message()), OverlapState::kFailed, entry);
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
  GiveUpAdjustment(island->second);
}

}  // namespace corbslam::map_store
