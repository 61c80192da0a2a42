// Decides what is to be fused of a mission, in which order, and what becomes of it.
#ifndef CORBSLAM_MAP_STORE_COORDINATION_FUSION_COORDINATOR_H_
#define CORBSLAM_MAP_STORE_COORDINATION_FUSION_COORDINATOR_H_

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "map_store/coordination/fusion_lanes.h"
#include "map_store/fusion/fusion_job.h"
#include "map_store/fusion/fusion_policy.h"
#include "map_store/fusion/revision_layers.h"
#include "map_store/mission/event_book.h"
#include "map_store/mission/mission_load.h"
#include "map_store/mission/mission_strand.h"
#include "map_store/records/journal_records.h"
#include "slam/exchange/agent_report.h"

namespace corbslam::map_store {

// Says what became of a job whose worker has answered.
enum class JobEnd {
  kDone,      // Its result is in the state, or is known to be worth nothing.
  kTryLater,  // The worker is not there.
  kRefused,   // The mission's journal takes nothing now: the result is kept for RetryCommit.
};

// What is committed of an adjustment, made before the writers' turn.
struct AdjustmentDraft {
  AdjustRecord record;  // `dirty` does not count yet what owners said.
  RevisionLayers layers;
};

// Asks the policy what comes next, keeps the lanes, and commits results through the mission's
// strand. Thread-safe.
class FusionCoordinator {
 public:
  // `strand` and `events` are not owned and must outlive it. `notify` is called, without locks,
  // when something that others see has changed.
  FusionCoordinator(MissionStrand& strand, EventBook& events, std::function<void()> notify);

  // Returns the next piece of work of a lane, which then is busy until the job is finished;
  // nullopt: there is none.
  std::optional<FusionJob> StartJob(FusionLane lane);
  // Commits the result, or notes the failure.
  JobEnd FinishJob(FusionLane lane, FusionJob job, absl::StatusOr<FusionResult> result)
      ABSL_LOCKS_EXCLUDED(refused_mutex_);
  // Commits a result again that the journal has refused, once it is time to try, so that no worker
  // computes it anew. Returns nullopt where the lane has none.
  std::optional<JobEnd> RetryCommit(FusionLane lane) ABSL_LOCKS_EXCLUDED(refused_mutex_);
  void CancelJobs();

  // Forgets what was fused; the lanes then derive it again.
  absl::Status Rederive();
  // Does what MapStore::RetractOverlap says.
  absl::StatusOr<std::vector<uint64_t>> RetractOverlap(uint64_t overlap, bool keep_apart);
  // Keeps what the agent is making apart from others' local maps that it says differ too much
  // (FindContradicted).
  void KeepApart(const std::string& agent, const std::vector<MapContradiction>& contradictions);

  bool IsIdle() const;
  // Returns whether nothing runs, and nothing but queries waits.
  bool RestsButForQueries() const;
  // Returns whether there would be something to do, had the store a worker.
  bool HasWork() const;
  bool WaitUntilIdle(absl::Time deadline) const;
  // Counts the requests that wait for workers, and those that workers have.
  FusionRequestCounts CountWaiting() const;
  // Ends all work of a mission that is deleted: there is nothing to do any more.
  void Stop();

 private:
  enum class Attempt {
    kStarted,
    kNothingToDo,
    kSkipped,      // The action needed no worker; the next one may.
    kInterrupted,  // The state changed meanwhile: the caller decides anew.
  };
  struct Started {
    Attempt attempt = Attempt::kNothingToDo;
    std::optional<FusionJob> job;
  };
  struct Claim {
    FusionAction action;
    CancelFlag cancelled;
    bool chooses_queried_maps = false;  // True: the local maps to query are not chosen yet.
  };

  // A result that the journal refused; its lane stays busy.
  struct Refused {
    FusionJob job;
    FusionResult result;
    absl::Time next_try;
  };

  JobEnd KeepRefused(FusionLane lane, FusionJob job, FusionResult result)
      ABSL_LOCKS_EXCLUDED(refused_mutex_);
  PolicyLimits Limits() const;
  FusionSummary Summarise() const ABSL_SHARED_LOCKS_REQUIRED(strand_.mutex());
  std::optional<FusionAction> NextAction(FusionLane lane) const
      ABSL_SHARED_LOCKS_REQUIRED(strand_.mutex());
  // Returns whether nothing runs and nothing waits, or nothing but queries.
  bool RestsLocked(bool but_for_look_ups) const ABSL_SHARED_LOCKS_REQUIRED(strand_.mutex());
  bool IsIdleLocked() const ABSL_SHARED_LOCKS_REQUIRED(strand_.mutex());
  Started TryStart(FusionLane lane);
  // Takes the lane for the caller until ReleaseLane. Returns nullopt if the lane has nothing to do.
  std::optional<Claim> ClaimLane(FusionLane lane);
  void ReleaseLane(FusionLane lane);
  absl::StatusOr<std::optional<FusionRequest>> Prepare(const Claim& claim);
  // Chooses which local maps the queue's first keyframe queries.
  Attempt Choose(const Claim& claim);
  // Says in the state that the action needs no worker.
  void SkipAction(const FusionAction& action) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_.mutex());
  // Writes a record that changes what jobs began with, and applies it.
  absl::Status CommitDecision(const JournalRecord& record,
                              absl::FunctionRef<void(MissionState&)> apply)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_.turn());
  absl::Status TellOfDecision();
  // Tells others, without locks, of what has changed.
  void TellOthers();
  // Notes what has happened; the change is applied.
  void NoteEvent(MissionEvent::What what) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_.turn());

  absl::Status Commit(const FusionJob& job, const FusionResult& result);
  absl::Status CommitQuery(const QueryJob& job, const VerifyOverlapResult& result)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_.turn());
  // `layers` holds the old ones afterwards.
  absl::Status CommitFuse(const FuseJob& job, const FuseMapsResult& result, RevisionLayers& layers)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_.turn());
  absl::Status CommitRefusedFuse(const FuseJob& job, const FuseMapsResult& result)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_.turn());
  // Plans the adjustment and prepares all that it changes while owners go on, then takes the turn.
  absl::Status CommitAdjust(const AdjustJob& job, const AdjustBundleResult& result,
                            const std::atomic<bool>& cancelled);
  // Returns false where the result is worth nothing any more.
  bool IsWanted(const AdjustJob& job, const std::atomic<bool>& cancelled) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_.turn());
  // Returns ABORTED if another revision came between, or nobody wants it any more.
  absl::StatusOr<AdjustmentDraft> DraftAdjustment(const AdjustJob& job,
                                                  const AdjustBundleResult& result,
                                                  const std::atomic<bool>& cancelled) const;
  // `draft` holds the old layers afterwards, which the caller gives up behind the turn: freeing
  // them takes time.
  absl::Status CommitDraft(const AdjustJob& job, AdjustmentDraft& draft)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_.turn());
  // Returns what a long read asks at its pauses: ABORTED once a revision is committed, or the work
  // is cancelled.
  std::function<absl::Status()> GoesOnUntilRevised(const std::atomic<bool>& cancelled) const
      ABSL_SHARED_LOCKS_REQUIRED(strand_.mutex());
  // Returns whether a revision that was committed after the job began has placed what the record
  // would place, so that the record is void; an urgent record never is.
  bool IsOvertaken(const FuseJob& job, const FuseRecord& record) const;
  // Returns the milliseconds since the first of the overlaps was verified.
  double SinceVerified(const std::vector<uint64_t>& overlaps) const
      ABSL_SHARED_LOCKS_REQUIRED(strand_.mutex());
  void NoteFailure(const FusionJob& job, const absl::Status& status)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_.mutex());
  void NoteFailedQuery(const QueryJob& job) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_.mutex());
  void NoteFailedFuse(const FuseJob& job, const absl::Status& status)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_.mutex());
  void NoteFailedAdjust(const AdjustJob& job) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_.mutex());

  MissionStrand& strand_;
  EventBook& events_;
  const std::function<void()> notify_;
  mutable absl::CondVar lane_released_;
  FusionLanes lanes_ ABSL_GUARDED_BY(strand_.mutex());
  // Of whoever has the graph lane.
  QueryViews query_views_;
  absl::Mutex refused_mutex_;
  std::array<std::optional<Refused>, kFusionLanes.size()> refused_ ABSL_GUARDED_BY(refused_mutex_);
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_COORDINATION_FUSION_COORDINATOR_H_
