// The map store without its transport: takes in the agents' batches, keeps both layers of every
// mission, finds overlaps and fuses with the help of a FusionWorker, shares the result and answers
// look-ups.
#ifndef CORBSLAM_MAP_STORE_MAP_STORE_H_
#define CORBSLAM_MAP_STORE_MAP_STORE_H_

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "map_store/archive/mission_archive.h"
#include "map_store/options.h"
#include "map_store/records/journal.h"
#include "map_store/state/lookups.h"
#include "map_store/view/map_watcher.h"
#include "slam/exchange/fusion_worker.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/shared_update.h"
#include "slam/exchange/uplink.h"
#include "slam/vocabulary/vocabulary.h"

namespace corbslam {

struct MissionLoad;

namespace map_store {
class FusionExecutor;
class MemoryBudget;
class Mission;
class SnapshotKeeper;
}  // namespace map_store

// Thread-safe. Listeners are called without any lock of the store held, from the thread that made
// the change; they must return soon and may call the store. Once a listener was removed or
// replaced, or its session closed, a call that was under way may still end.
class MapStore {
 public:
  // Where its times come from.
  using Clock = std::function<absl::Time()>;

  struct OpenedSession {
    uint64_t session_id = 0;
    SessionGrant grant;
  };

  // `worker` (not owned) must outlive the store; null: nothing is ever verified or fused.
  // `options` must be valid. Without `options.deterministic` it starts its fusion threads.
  MapStore(const MapStoreOptions& options, std::shared_ptr<const Vocabulary> vocabulary,
           std::unique_ptr<Journal> journal, FusionWorker* worker, Clock clock = &absl::Now);
  // Cancels what runs on the worker and joins its threads.
  ~MapStore();
  MapStore(const MapStore&) = delete;
  MapStore& operator=(const MapStore&) = delete;

  // Takes in what the journal has. Once, before all else; nothing else may be called if it fails.
  // DATA_LOSS, naming the mission and the place, for what can't be read.
  absl::Status Recover();

  // Whether it takes batches now, as far as the journal knows (Journal::CheckWritable).
  absl::Status CheckWritable() { return journal_->CheckWritable(); }

  // Sessions: one an agent.

  // Opens or resumes; creates the mission and the agent. An older session of the same agent is
  // fenced: its calls answer ABORTED from now on, and its shared listener is called once.
  // ALREADY_EXISTS: it stands, and was opened by another process (SessionRequest::instance) than
  // this one, which is not to take over. INVALID_ARGUMENT: a name is empty, longer than 128 or has
  // other characters than [a-zA-Z0-9._-]. PERMISSION_DENIED: a local map is another agent's.
  // RESOURCE_EXHAUSTED.
  absl::StatusOr<OpenedSession> OpenSession(const SessionRequest& request);
  // Applies the batch as a whole or not at all, and answers up to where the local map is stored.
  // A batch seen before is acknowledged, not applied again. FAILED_PRECONDITION names the expected
  // number where some are missing. ABORTED: fenced. NOT_FOUND: no such session.
  // INVALID_ARGUMENT, PERMISSION_DENIED, RESOURCE_EXHAUSTED: nothing was stored, the session goes
  // on. Errors of the journal: nothing was stored, or it is not certain that it would survive; the
  // batch is to be sent again.
  // What is acknowledged is durable, as far as the journal is.
  absl::StatusOr<Acknowledgement> Apply(uint64_t session_id, const MapUpdateBatch& batch,
                                        const BatchTransfer* measured = nullptr);
  void CloseSession(uint64_t session_id);

  // The next step of what the agent lacks, or none when it has all. At most about `byte_budget`
  // bytes (at least one item). ABORTED when fenced.
  absl::StatusOr<std::optional<SharedUpdate>> NextShared(uint64_t session_id, size_t byte_budget);
  // Has the agent tell where its points are, exactly (MapUpdateBatch::points_follow). NOT_FOUND;
  // FAILED_PRECONDITION: it is not connected.
  absl::Status AskForExactPlaces(absl::string_view mission, const std::string& agent);
  // Whether somebody has asked for that and the session's agent is to be told so; once.
  bool TakeExactPlacesWanted(uint64_t session_id);
  // Called when NextShared or TakeExactPlacesWanted may have something, or the session was fenced.
  // Null removes it.
  void SetSharedListener(uint64_t session_id, std::function<void()> listener);

  // Fusion. All answer NOT_FOUND for an unknown mission.

  // Deterministic mode: runs queries, verification, fusing and adjustment here and now.
  absl::Status RunFusionUntilIdle(absl::string_view mission);
  // Forgets all that was fused and queues every keyframe again, in the order of ids: the same
  // owners' layer gives the same global layer, bit by bit in deterministic mode. Durable when it
  // returns.
  absl::Status RederiveGlobalLayer(absl::string_view mission);
  // Takes back an accepted overlap (OverlapInfo::id) and what followed from it: its island falls
  // apart and is fused again by the other overlaps. The same two keyframes are never joined again;
  // with `keep_apart` neither are the two local maps, whose other overlaps go too. Returns the ids
  // of what was taken back. Durable when it returns. NOT_FOUND; FAILED_PRECONDITION: not accepted.
  absl::StatusOr<std::vector<uint64_t>> RetractOverlap(absl::string_view mission, uint64_t overlap,
                                                       bool keep_apart);
  absl::StatusOr<bool> IsFusionIdle(absl::string_view mission) const;
  // DEADLINE_EXCEEDED after `timeout`.
  absl::Status WaitUntilFusionIdle(absl::string_view mission, absl::Duration timeout) const;

  // The process's memory: 0 for no budget; how often something was refused for want of it.
  struct Memory {
    uint64_t budget_bytes = 0;
    uint64_t refused = 0;
  };
  Memory memory() const;

  // Whether there are fusion workers at all, and since when they take no requests; none before the
  // first request.
  bool has_worker() const;
  std::optional<WorkerOutage> worker_outage() const;

  // Look-ups. NOT_FOUND, naming what; INVALID_ARGUMENT for a bad page token.

  absl::StatusOr<Page<MissionInfo>> ListMissions(const PageRequest& page) const;
  absl::StatusOr<MissionInfo> GetMission(absl::string_view mission) const;
  // Sessions in it are fenced.
  absl::Status DeleteMission(absl::string_view mission);
  // The mission as it is now, to be written to a file while it goes on.
  absl::StatusOr<MissionBackup> BackUpMission(absl::string_view mission) const;
  // Where a backup's pieces go; takes no more than the options' limit.
  MissionRestorer StartRestoring() const;
  // Makes a mission of what a MissionRestorer has read, under a name that need not be the old one.
  // Agents of it go on where the backup has them. Durable when it returns. ALREADY_EXISTS;
  // INVALID_ARGUMENT, RESOURCE_EXHAUSTED: what is in it would not be taken from agents either.
  absl::Status RestoreMission(const std::string& mission, map_store::MissionState state);
  absl::StatusOr<Page<AgentInfo>> ListAgents(absl::string_view mission,
                                             const PageRequest& page) const;
  absl::StatusOr<Page<LocalMapInfo>> ListLocalMaps(absl::string_view mission,
                                                   const PageRequest& page) const;
  absl::StatusOr<LocalMapInfo> GetLocalMap(absl::string_view mission, LocalMapId id) const;
  // Of one local map, or of all (invalid id).
  absl::StatusOr<Page<KeyframeInfo>> ListKeyframes(absl::string_view mission, LocalMapId local_map,
                                                   const PageRequest& page) const;
  absl::StatusOr<KeyframeInfo> GetKeyframe(absl::string_view mission, KeyframeId id) const;
  absl::StatusOr<MissionStatistics> GetStatistics(absl::string_view mission) const;
  // Of all missions (mission_load.h). Cheaper than the look-ups above: nothing is walked through
  // but local maps and what waits for fusion.
  std::vector<MissionLoad> ListLoads() const;
  // Of one agent, or of all (empty name) in the order of names. Global: only what lies in the
  // reference island, unless `all_islands`. FAILED_PRECONDITION: an agent never said where the
  // frame is that `poses_of` wants.
  absl::StatusOr<std::vector<AgentTrajectory>> GetTrajectory(
      absl::string_view mission, absl::string_view agent, TrajectoryFrame frame,
      bool all_islands = false, PosesOf poses_of = PosesOf::kRecordedCamera) const;
  absl::StatusOr<Page<OverlapInfo>> ListOverlaps(absl::string_view mission,
                                                 const OverlapFilter& filter,
                                                 const PageRequest& page) const;

  // All islands, the reference island first.
  absl::StatusOr<std::vector<IslandView>> GlobalMapView(absl::string_view mission) const;
  // The next piece of what changed since the watcher saw it last, of about `max_items` keyframes
  // and points; none when nothing has.
  absl::StatusOr<std::optional<MapChanges>> NextChanges(absl::string_view mission, size_t max_items,
                                                        MapWatcher& watcher) const;
  // Called after each change; several may be added. The token removes it.
  absl::StatusOr<uint64_t> AddMapListener(absl::string_view mission,
                                          std::function<void()> listener);
  void RemoveMapListener(absl::string_view mission, uint64_t token);

 private:
  struct Session {
    std::string agent;
    std::shared_ptr<map_store::Mission> mission;
  };

  absl::StatusOr<std::shared_ptr<map_store::Mission>> FindMission(absl::string_view name) const;
  // Registers a session in the mission, which is made if there is none. Its id.
  absl::StatusOr<uint64_t> EnterMission(const std::string& name, const std::string& agent);
  // Forgets the session, and the mission if nothing was ever written of it and nobody is in it.
  void LeaveMission(uint64_t session_id);
  // There may be something to fuse, or to be made a snapshot of.
  void Wake();
  std::shared_ptr<map_store::Mission> MakeMission(const std::string& name);
  absl::Status CheckRoomForMission() const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  absl::StatusOr<Session> FindSession(uint64_t session_id) const;
  MissionInfo Describe(const map_store::Mission& mission) const;

  const MapStoreOptions options_;
  const std::shared_ptr<const Vocabulary> vocabulary_;
  const std::unique_ptr<Journal> journal_;
  const Clock clock_;
  const std::unique_ptr<map_store::MemoryBudget> memory_;
  std::unique_ptr<map_store::FusionExecutor> executor_;
  std::unique_ptr<map_store::SnapshotKeeper> snapshots_;

  // Held by one deletion from its beginning to its end.
  absl::Mutex deletion_mutex_ ABSL_ACQUIRED_BEFORE(mutex_);
  mutable absl::Mutex mutex_;
  std::map<std::string, std::shared_ptr<map_store::Mission>, std::less<>> missions_
      ABSL_GUARDED_BY(mutex_);
  // Names of missions that are being restored.
  std::set<std::string, std::less<>> restoring_ ABSL_GUARDED_BY(mutex_);
  std::map<uint64_t, Session> sessions_ ABSL_GUARDED_BY(mutex_);
  uint64_t next_session_ ABSL_GUARDED_BY(mutex_) = 1;
};

}  // namespace corbslam

#endif  // CORBSLAM_MAP_STORE_MAP_STORE_H_
