// One mission: its state behind a lock, a strand of writers, its sessions and its fusion lanes.
#ifndef CORBSLAM_MAP_STORE_MISSION_MISSION_H_
#define CORBSLAM_MAP_STORE_MISSION_MISSION_H_

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "map_store/fusion/fusion_job.h"
#include "map_store/fusion/fusion_policy.h"
#include "map_store/fusion/revision.h"
#include "map_store/ingest/batch_application.h"
#include "map_store/options.h"
#include "map_store/records/journal.h"
#include "map_store/state/mission_state.h"
#include "map_store/state/share_state.h"
#include "slam/exchange/uplink.h"
#include "slam/vocabulary/vocabulary.h"

namespace corbslam {
struct MissionLoad;
}  // namespace corbslam

namespace corbslam::map_store {

// Verification and fusing, one after the other; bundle adjustment beside them.
enum class FusionLane { kGraph, kAdjustment };

// Thread-safe. Writers take their turn on a strand (writer_mutex_) that is held while the journal
// writes; the state's own lock is held only to read or to change memory, never across the journal,
// a worker or a listener.
class Mission {
 public:
  struct Environment {
    const MapStoreOptions* options = nullptr;
    const Vocabulary* vocabulary = nullptr;
    Journal* journal = nullptr;
    std::function<absl::Time()> clock;
    // Called, without locks, when there may be something to fuse.
    std::function<void()> wake_fusion;
    bool has_worker = false;
  };

  Mission(std::string name, Environment environment);

  // What the journal has of it. Before anything else. DATA_LOSS: names what can't be had.
  absl::Status Recover();
  // Likewise a state from elsewhere, which the journal has.
  void Restore(MissionState state);
  // Writes a snapshot into the journal, if it wants one. It is made from the journal itself, beside
  // the strand and the state's lock. CANCELLED once the mission is deleted or `goes_on`, called
  // often, says no.
  absl::Status KeepSnapshot(const std::function<bool()>& goes_on)
      ABSL_LOCKS_EXCLUDED(snapshot_mutex_, writer_mutex_, mutex_);

  // Fences an older session of the agent, unless another process holds that.
  absl::StatusOr<SessionGrant> OpenSession(uint64_t session_id, const SessionRequest& request);
  absl::StatusOr<Acknowledgement> Apply(uint64_t session_id, const std::string& agent,
                                        const MapUpdateBatch& batch, const BatchTransfer* measured);
  void CloseSession(uint64_t session_id, const std::string& agent);
  absl::StatusOr<std::optional<SharedUpdate>> NextShared(uint64_t session_id,
                                                         const std::string& agent,
                                                         size_t byte_budget);
  // MapStore::AskForExactPlaces, MapStore::TakeExactPlacesWanted.
  absl::Status AskForExactPlaces(const std::string& agent);
  bool TakeExactPlacesWanted(const std::string& agent);
  void SetSharedListener(uint64_t session_id, std::function<void()> listener);
  // The token is no other mission's: another one may have got the name when it is removed.
  uint64_t AddMapListener(std::function<void()> listener);
  void RemoveMapListener(uint64_t token);
  // Tells all listeners that something changed.
  void NotifyAll(uint64_t except_session);

  // Ends everything: sessions are fenced, jobs cancelled, nothing is written any more.
  void Delete();

  // Reads the state under its lock; `read` must be quick and must not call back.
  template <typename Read>
  auto WithState(Read read) const {
    absl::ReaderMutexLock lock(&mutex_);
    return read(static_cast<const MissionState&>(state_));
  }

  // Fusion. The next piece of work of a lane, which then is busy until the job is finished.
  std::optional<FusionJob> StartJob(FusionLane lane);
  // Commits the result, or notes the failure. False: the worker is not there or the journal takes
  // nothing, try again later.
  bool FinishJob(FusionLane lane, const FusionJob& job, absl::StatusOr<FusionResult> result);
  void CancelJobs() ABSL_LOCKS_EXCLUDED(mutex_);
  // Forgets what was fused; the lanes derive it again.
  absl::Status Rederive() ABSL_LOCKS_EXCLUDED(writer_mutex_, mutex_);
  // MapStore::RetractOverlap.
  absl::StatusOr<std::vector<uint64_t>> RetractOverlap(uint64_t overlap, bool keep_apart)
      ABSL_LOCKS_EXCLUDED(writer_mutex_, mutex_);
  bool IsFusionIdle() const;
  MissionLoad Load() const;
  MissionInfo Info() const;
  bool WaitUntilFusionIdle(absl::Time deadline) const;

 private:
  struct Lane {
    bool busy = false;
    // Of what runs.
    FusionAction::Kind kind = FusionAction::Kind::kQuery;
    IslandId target;
    std::shared_ptr<std::atomic<bool>> cancelled;
  };

  // Of an island's adjustments since the last one that was committed.
  struct AdjustmentTrouble {
    int failed = 0;
    size_t cancelled = 0;  // By welding or fusing.
  };

  // What one agent was told. Who tells it more holds the state's lock for reading.
  struct Told {
    absl::Mutex mutex;
    ShareState share ABSL_GUARDED_BY(mutex);
    // By somebody, and the agent has not been asked.
    bool exact_places_wanted ABSL_GUARDED_BY(mutex) = false;
  };
  class PausingRead;

  void Begin(MissionState state) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status CheckSession(uint64_t session_id, const std::string& agent) const
      ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  absl::Status CheckBatch(uint64_t session_id, const std::string& agent,
                          const MapUpdateBatch& batch, std::optional<Acknowledgement>& known) const
      ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  absl::Status ApplyNext(const std::string& agent, const MapUpdateBatch& batch,
                         const BatchWords& words) ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_);
  void CountTransfer(const MapUpdateBatch& batch, const BatchTransfer* measured, double ms)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  PolicyLimits Limits() const;
  FusionSummary Summarise() const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  std::optional<FusionAction> NextAction(FusionLane lane) const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  // Starts the next piece of work, if there is any; true: nothing came of it, go on. Work that was
  // interrupted too often waits for the next wake-up.
  bool TryStart(FusionLane lane, int& interruptions, std::optional<FusionJob>& job)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // The lane is the caller's from here on, until ReleaseLane.
  std::optional<FusionAction> ClaimLane(FusionLane lane,
                                        std::shared_ptr<std::atomic<bool>>& cancelled)
      ABSL_LOCKS_EXCLUDED(mutex_);
  absl::StatusOr<std::optional<FusionRequest>> Prepare(const FusionAction& action,
                                                       const std::atomic<bool>& cancelled) const
      ABSL_LOCKS_EXCLUDED(mutex_);
  bool IsIdleLocked() const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  // The action needs no worker: says so in the state.
  void SkipAction(const FusionAction& action) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  // What the mission's graph was after a record, from the journal.
  absl::StatusOr<MissionState> ReplayUntil(Journal::Position position,
                                           const std::function<bool()>& goes_on) const
      ABSL_LOCKS_EXCLUDED(mutex_);
  // It stays as it is while the strand is held.
  bool IsDeleted() const ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status Deleted() const;
  absl::Status Append(const JournalRecord& record) ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_);
  // All that was appended so far is durable.
  absl::Status SyncJournal() ABSL_LOCKS_EXCLUDED(writer_mutex_, mutex_);

  absl::Status CommitQuery(const QueryJob& job, const VerifyOverlapResult& result)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_);
  absl::Status CommitFuse(const FuseJob& job, const FuseMapsResult& result)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_);
  absl::Status CommitAdjust(const AdjustJob& job, const AdjustBundleResult& result)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_);
  absl::Status Commit(const FusionJob& job, const FusionResult& result);
  // A revision that was committed after the job began has placed what the record would place.
  bool IsOvertaken(const FuseJob& job, const FuseRecord& record) const ABSL_LOCKS_EXCLUDED(mutex_);
  // Milliseconds since the first of the overlaps was verified.
  double SinceVerified(const std::vector<uint64_t>& overlaps) const
      ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  void NoteFailure(const FusionJob& job, const absl::Status& status)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void CancelJobsLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // What is being adjusted is not the island's graph any more.
  void CancelAdjustment(const FusionAction& overtaken_by) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void ReleaseLane(FusionLane lane);

  std::function<void()> SharedListener(uint64_t session_id) const
      ABSL_LOCKS_EXCLUDED(listener_mutex_);
  std::vector<std::function<void()>> ListenersExcept(uint64_t session_id) const
      ABSL_LOCKS_EXCLUDED(listener_mutex_);

  const std::string name_;
  const Environment environment_;

  // Held from a snapshot's beginning to its end.
  absl::Mutex snapshot_mutex_ ABSL_ACQUIRED_BEFORE(writer_mutex_);
  absl::Mutex writer_mutex_ ABSL_ACQUIRED_BEFORE(mutex_);
  // Of the last append.
  std::atomic<Journal::Position> appended_ = 0;
  mutable absl::Mutex mutex_;
  mutable absl::CondVar lane_released_;
  MissionState state_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, Told> told_ ABSL_GUARDED_BY(mutex_);  // Of all agents with a session.
  std::array<Lane, 2> lanes_ ABSL_GUARDED_BY(mutex_);
  std::map<IslandId, AdjustmentTrouble> adjustment_trouble_ ABSL_GUARDED_BY(mutex_);
  bool deleted_ ABSL_GUARDED_BY(mutex_) = false;

  mutable absl::Mutex listener_mutex_;
  std::map<uint64_t, std::function<void()>> shared_listeners_ ABSL_GUARDED_BY(listener_mutex_);
  std::map<uint64_t, std::function<void()>> map_listeners_ ABSL_GUARDED_BY(listener_mutex_);
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_MISSION_H_
