// Mission's fusion lanes: what to do next, who does it, and what ends it early.
#include <algorithm>
#include <utility>

#include "map_store/mission/mission.h"
#include "map_store/records/record_application.h"
#include "map_store/records/retraction.h"
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
  for (const uint64_t id : state_.global.overlaps.waiting()) {
    const OverlapEntry& entry = state_.global.overlaps.at(id);
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
  limits.adjust_share = environment_.options->adjust_share;
  limits.adjust_min_keyframes = environment_.options->adjust_min_keyframes;
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

}  // namespace corbslam::map_store
