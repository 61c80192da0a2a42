// The map store without its transport: it takes in the agents' batches, keeps both layers of every
// mission, finds overlaps and fuses maps with the help of a FusionWorker, shares the result and
// answers look-ups.
#ifndef CORBSLAM_MAP_STORE_STORE_MAP_STORE_H_
#define CORBSLAM_MAP_STORE_STORE_MAP_STORE_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "map_store/archive/mission_archive.h"
#include "map_store/joining/forgetting.h"
#include "map_store/locating/localize_query.h"
#include "map_store/options/options.h"
#include "map_store/records/journal.h"
#include "map_store/state/lookups.h"
#include "map_store/state/mission_event.h"
#include "map_store/state/mission_profile.h"
#include "map_store/view/map_replay.h"
#include "map_store/view/map_watcher.h"
#include "slam/exchange/fusion_worker.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/shared_update.h"
#include "slam/exchange/uplink.h"
#include "slam/vocabulary/vocabulary.h"

namespace corbslam {
class MemoryReturner;
}  // namespace corbslam

namespace corbslam::map_store {

struct KnownMission;
struct MissionLoad;
struct DirectoryMission;
struct EvictedMission;

class DepartedMissions;
class FusionExecutor;
class MemoryBudget;
class Mission;
class LoadMeter;
class MissionDirectory;
class MissionTender;
class MissionLoader;
class PromisedUids;
class MissionEvictor;
class SnapshotKeeper;

// The store of all missions. It is thread-safe. Listeners are called without any lock of the store
// held, from the thread that made the change; they must return soon and may call the store. Once a
// listener was removed or replaced, or its session closed, a call that was under way may still end.
class MapStore {
 public:
  // Says what time it is.
  using Clock = std::function<absl::Time()>;

  // Is told that a mission was deleted because its retention has passed, and why.
  using ExpiryListener = std::function<void(const std::string& mission, const std::string& why)>;
  // Is told which uid a mission has from now on: it was made, or is older than uids. It must return
  // soon, and may not call the store.
  using UidListener = std::function<void(const std::string& mission, const std::string& uid)>;

  struct OpenedSession {
    uint64_t session_id = 0;
    SessionGrant grant;
  };

  // `worker` (not owned) must outlive the store; without one (null) nothing is ever verified or
  // fused. `options` must be valid. The store starts its fusion threads unless
  // `options.deterministic`.
  MapStore(const MapStoreOptions& options, std::shared_ptr<const Vocabulary> vocabulary,
           std::unique_ptr<Journal> journal, FusionWorker* worker, Clock clock = &absl::Now);
  // Cancels what runs on the worker and joins the store's threads.
  ~MapStore();
  MapStore(const MapStore&) = delete;
  MapStore& operator=(const MapStore&) = delete;

  // Takes in what the journal has. The caller calls it once, before all else, and calls nothing
  // else if it fails. A mission that can't be read is damaged: it is there by its name, so that it
  // can be deleted, and all else that is asked of it gets DATA_LOSS with the place and what to do.
  absl::Status Recover();
  // Returns what is damaged of the missions that are, those included that the journal found damaged
  // since; by name.
  std::map<std::string, std::string> ListDamaged() const;

  // Returns OK if the store takes batches now, as far as the journal knows
  // (Journal::CheckWritable).
  absl::Status CheckWritable() { return journal_->CheckWritable(); }

  // Sessions: an agent has one at a time.

  // Opens or resumes a session; creates the mission and the agent where there are none, but returns
  // NOT_FOUND for an agent that changes nothing where there is no such mission, and ABORTED
  // (session_end.h) to a process of a mission that is deleted, whether it names its uid or is
  // remembered to have been in it. An older
  // session of the same agent is fenced: its calls return ABORTED from now on, and its shared
  // listener is called once. Returns ALREADY_EXISTS if the older session was opened by another
  // process (SessionRequest::instance) and this one is not to take over, INVALID_ARGUMENT if a name
  // is empty, longer than 128 or has other characters than [a-zA-Z0-9._-], PERMISSION_DENIED if a
  // local map is another agent's, and RESOURCE_EXHAUSTED beyond a limit.
  absl::StatusOr<OpenedSession> OpenSession(const SessionRequest& request);
  // Applies the batch as a whole or not at all, and returns up to which batch the local map is
  // stored. A batch seen before is acknowledged, not applied again. Returns FAILED_PRECONDITION,
  // naming the expected number, where batches are missing, ABORTED if the session is fenced, and
  // NOT_FOUND if there is no such session. After INVALID_ARGUMENT, PERMISSION_DENIED or
  // RESOURCE_EXHAUSTED nothing was stored, and the session goes on. After an error of the journal
  // nothing was stored, or it is not certain that it would survive; the agent is to send the batch
  // again.
  // What is acknowledged is durable, as far as the journal is.
  absl::StatusOr<Acknowledgement> Apply(uint64_t session_id, const MapUpdateBatch& batch,
                                        const BatchTransfer* measured = nullptr);
  // `on_purpose`: the agent ended it itself, with all that it had told; false: the line broke.
  void CloseSession(uint64_t session_id, bool on_purpose = false);
  // Counts bytes of batches that came in the session. Returns how long the agent's stream is not to
  // be read, so that it sends no more a second than its limit (UplinkLimit), but for a burst.
  absl::Duration PaceUplink(uint64_t session_id, uint64_t bytes);

  // Returns the next step of what the agent lacks, or none when it has all; about `byte_budget`
  // bytes at most, but at least one item. Returns ABORTED when the session is fenced.
  absl::StatusOr<std::optional<SharedUpdate>> NextShared(uint64_t session_id, size_t byte_budget);
  // Notes where frames were of an agent that changes nothing (SessionRequest::localise_only): what
  // is near it follows, and look-ups say it. A part of its trajectory is kept; returns up to which
  // part of its run everything is durable, or nullopt if there is none or it can't be kept now (the
  // journal, memory or a limit): the agent is to send it again. A part that leaves a gap is not
  // kept. Returns PERMISSION_DENIED if the session is of another agent, else as Apply.
  absl::StatusOr<std::optional<LocalisedKept>> NoteLocalised(uint64_t session_id,
                                                             const LocalisedFrames& localised);
  // Keeps a keyframe's picture, for people. One that can't be kept is passed over: its keyframe is
  // not there or has one, or there is no room. INVALID_ARGUMENT as ValidatePicture,
  // PERMISSION_DENIED if the local map is another agent's, or the session changes nothing; else as
  // Apply.
  absl::Status KeepPicture(uint64_t session_id, const KeyframePicture& picture);
  // Keeps what an agent says of itself, in memory and until it says something else. Returns as
  // Apply.
  absl::Status NoteReport(uint64_t session_id, const AgentReport& report);
  // Has the agent tell exactly where its points are (MapUpdateBatch::points_follow). Returns
  // NOT_FOUND if there is no such agent, FAILED_PRECONDITION if it is not connected.
  absl::Status AskForExactPlaces(absl::string_view mission, const std::string& agent);
  // Returns, once only, whether somebody has called AskForExactPlaces for the session's agent.
  bool TakeExactPlacesWanted(uint64_t session_id);
  // Sets what is called when NextShared, TakeExactPlacesWanted or NewerSettings may have something,
  // or the session was fenced. Null removes the listener. It is not called for the session's own
  // batches, after which NextShared may have something for who wants what is near it
  // (ShareMode::kNearby).
  void SetSharedListener(uint64_t session_id, std::function<void()> listener);

  // Fusion. All these functions return NOT_FOUND for an unknown mission.

  // Runs queries, verification, fusing and adjustment here and now; for deterministic mode.
  absl::Status RunFusionUntilIdle(absl::string_view mission);
  // Forgets all that was fused and queues every keyframe again, in the order of ids: the same
  // owners' layer gives the same global layer, bit by bit in deterministic mode. The change is
  // durable when the function returns.
  absl::Status RederiveGlobalLayer(absl::string_view mission);
  // Takes back an accepted overlap (OverlapInfo::id) and what followed from it: its island falls
  // apart and is fused again by the other overlaps. The same two keyframes are never joined again;
  // with `keep_apart` neither are the two local maps, whose other overlaps are taken back as well.
  // Returns the ids of what was taken back; the change is durable then. Returns NOT_FOUND if there
  // is no such overlap, FAILED_PRECONDITION if it is not accepted.
  absl::StatusOr<std::vector<uint64_t>> RetractOverlap(absl::string_view mission, uint64_t overlap,
                                                       bool keep_apart);
  // Deletes an agent's closed local maps by age or number (map_store/joining/forgetting.h), and
  // returns them; with `dry_run` it deletes nothing. The change is durable then. NOT_FOUND;
  // INVALID_ARGUMENT for a request that is none; FAILED_PRECONDITION while fusion is busy.
  absl::StatusOr<ForgottenLocalMaps> ForgetLocalMaps(absl::string_view mission,
                                                     const ForgetRequest& request);
  absl::StatusOr<bool> IsFusionIdle(absl::string_view mission) const;
  // Returns DEADLINE_EXCEEDED after `timeout`.
  absl::Status WaitUntilFusionIdle(absl::string_view mission, absl::Duration timeout) const;

  // The process's memory budget in bytes (0: there is none), and how often something was refused
  // for want of it.
  struct Memory {
    uint64_t budget_bytes = 0;
    uint64_t refused = 0;
  };
  Memory memory() const;

  // Returns whether there are fusion workers at all, and since when they have taken no requests;
  // none before the first request.
  bool has_worker() const;
  std::optional<WorkerOutage> worker_outage() const;

  // Look-ups. They return NOT_FOUND, naming what is missing, and INVALID_ARGUMENT for a bad page
  // token.

  absl::StatusOr<Page<MissionInfo>> ListMissions(const PageRequest& page) const;
  absl::StatusOr<MissionInfo> GetMission(absl::string_view mission) const;
  // Where several stores share the missions of one journal (Journal::leases), this one has those
  // that it was asked for first. All calls about a mission that another store has return an error
  // that says where it is (slam/exchange/mission_elsewhere.h), and so do calls of sessions once the
  // mission was lost to another one; lists have all missions, but of others' their names and sizes
  // alone.

  // Drops missions that this store has no more, and has robots wait while it can't know; the
  // store's own thread does this several times a second, unless `options.deterministic`.
  void KeepLeases();
  // Tells other stores that share the missions how much this one has to do; the store's own thread
  // does it with KeepLeases, every few seconds.
  void TellLoad();
  // Null: the missions are not shared.
  MissionLeases* leases() const { return leases_; }

  // Makes a mission that has no robots yet. It is durable when the function returns OK.
  // ALREADY_EXISTS; INVALID_ARGUMENT for a name or a profile that is none; RESOURCE_EXHAUSTED.
  absl::Status CreateMission(const std::string& mission, const MissionProfile& profile);
  // Changes these fields of the mission's profile to those of `values`. The change is durable when
  // the function returns, and counts for sessions that are open. ABORTED, naming both, if another
  // MissionProfile::revision was expected than there is.
  absl::Status UpdateMission(absl::string_view mission, const MissionProfile& values,
                             const std::vector<ProfileField>& fields,
                             std::optional<uint64_t> expected_revision = std::nullopt);
  // Keeps settings for one robot of the mission, which need not have come yet, or for all (empty
  // agent), and tells them to those that are connected; durable likewise. Errors: PutSettings.
  absl::Status SetRobotSettings(absl::string_view mission, const std::string& agent,
                                const SignedSettings& settings);
  // Returns the settings that the session's robot was not told yet (ProfileKeeper::NewerSettings).
  std::vector<SignedSettings> NewerSettings(uint64_t session_id, SettingsVersions& told) const;
  // Deletes the missions that nobody has used for as long as their retention, and writes down when
  // the others were used. The store's own thread does this once a minute, unless
  // `options.deterministic`.
  void TendMissions();
  void SetExpiryListener(ExpiryListener listener);
  // Called before Recover.
  void SetUidListener(UidListener listener) { uid_listener_ = std::move(listener); }
  // Deletes the mission and fences the sessions in it. What it took of the disk is free when the
  // function returns, what it took of memory a moment later. FAILED_PRECONDITION: the name is not
  // that of the mission with this uid, unless that is empty.
  absl::Status DeleteMission(absl::string_view mission, absl::string_view uid = "");
  // Deletes it if no session is open in it and `may`, which is called while nobody can write to the
  // mission, returns OK. FAILED_PRECONDITION names who is connected. Who connects meanwhile gets
  // UNAVAILABLE: the next try finds the mission as it was, or makes another one.
  absl::Status DeleteUnusedMission(absl::string_view mission,
                                   const std::function<absl::Status()>& may);
  absl::Status CheckNobodyConnected(absl::string_view mission) const;
  // Keeps the mission in memory for as long as the caller holds what this returns, which waits
  // until it is awake.
  absl::StatusOr<std::shared_ptr<const void>> HoldAwake(absl::string_view mission) const;

  // Missions that nobody uses leave memory (MapStoreOptions::sleep_after_s): ListMissions,
  // GetMission and ListLoads answer from what they fell asleep with, and whatever else needs one
  // reads it first, which takes as long as at the start. It then returns DATA_LOSS for one that
  // turns out to be damaged, and RESOURCE_EXHAUSTED where memory has no room for it.

  // Puts the mission to sleep now. FAILED_PRECONDITION, with the reason, where it has to stay in
  // memory: it is used or watched, fusion has work to do, or there is no journal.
  absl::Status SleepMission(absl::string_view mission);
  // Puts those to sleep whose time has come, here and now; for deterministic mode. Returns their
  // number.
  size_t SleepUnused();
  // Calls `then` once the mission is awake (MissionLoader::WhenLoaded), for a caller that got
  // AsleepError's (MapStoreOptions::wake_in_background). RESOURCE_EXHAUSTED: too many wait.
  absl::Status WhenAwake(
      const std::string& mission,
      std::function<void(const absl::StatusOr<std::shared_ptr<const void>>& awake)> then);
  struct Sleep {
    size_t asleep = 0;  // Missions that sleep now.
    // How often one fell asleep, and was read again, and seconds that reading took all together.
    uint64_t fallen_asleep = 0;
    uint64_t woken = 0;
    double waking_s = 0;
  };
  Sleep sleep() const;

  // Returns the mission as it is now, to be written to a file while the mission goes on.
  absl::StatusOr<MissionBackup> BackUpMission(absl::string_view mission) const;
  // Returns where a backup's pieces go; the restorer takes no more than the options' limit.
  MissionRestorer StartRestoring() const;
  // Returns the error that RestoreMission would give of the name, or RESOURCE_EXHAUSTED if a backup
  // of so many bytes is larger than is taken in, or than there is memory for.
  absl::Status CheckRoomToRestore(const std::string& mission, uint64_t bytes) const;
  // Makes a mission of what a MissionRestorer has read, under a name that need not be the old one.
  // Its agents go on where the backup has them. The mission is durable when the function returns.
  // Returns ALREADY_EXISTS, or INVALID_ARGUMENT and RESOURCE_EXHAUSTED for content that would not
  // be taken from agents either.
  absl::Status RestoreMission(const std::string& mission, MissionState state);
  // Takes over what pictures another journal has of a mission that was restored from it, as far as
  // there is room.
  void TakePictures(const std::string& mission, const Journal& from, absl::string_view there);
  absl::StatusOr<Page<AgentInfo>> ListAgents(absl::string_view mission,
                                             const PageRequest& page) const;
  absl::StatusOr<Page<LocalMapInfo>> ListLocalMaps(absl::string_view mission,
                                                   const PageRequest& page) const;
  absl::StatusOr<LocalMapInfo> GetLocalMap(absl::string_view mission, LocalMapId id) const;
  // Returns the keyframes of one local map, or of all (invalid id).
  absl::StatusOr<Page<KeyframeInfo>> ListKeyframes(absl::string_view mission, LocalMapId local_map,
                                                   const PageRequest& page) const;
  absl::StatusOr<KeyframeInfo> GetKeyframe(absl::string_view mission, KeyframeId id,
                                           bool with_sights = false) const;
  // Returns the keyframe's picture; nullopt: its robot sent none, or it is not kept. NOT_FOUND as
  // GetKeyframe.
  absl::StatusOr<std::optional<KeyframePicture>> GetPicture(absl::string_view mission,
                                                            KeyframeId id) const;
  absl::StatusOr<MissionStatistics> GetStatistics(absl::string_view mission) const;
  // Returns the load of each mission (mission_load.h). This costs less than the look-ups above:
  // only local maps and what waits for fusion are walked through.
  std::vector<MissionLoad> ListLoads() const;
  // Returns the trajectory of one agent, or of all (empty name) in the order of names. A global
  // trajectory has only what lies in the reference island, unless `all_islands`. Returns
  // FAILED_PRECONDITION if an agent never said where the frame is that `poses_of` asks for. What an
  // agent only localised is in no local frame, and so in no local trajectory.
  absl::StatusOr<std::vector<AgentTrajectory>> GetTrajectory(
      absl::string_view mission, absl::string_view agent, TrajectoryFrame frame,
      bool all_islands = false, PosesOf poses_of = PosesOf::kRecordedCamera) const;
  // Finds where a picture was taken (LocalizePicture). It blocks while workers work, and changes
  // nothing. UNAVAILABLE: there is no worker, or none takes requests.
  absl::StatusOr<LocalizeAnswer> Localize(absl::string_view mission, const LocalizeQuery& query,
                                          const std::function<bool()>& goes_on) const;
  absl::StatusOr<Page<OverlapInfo>> ListOverlaps(absl::string_view mission,
                                                 const OverlapFilter& filter,
                                                 const PageRequest& page) const;

  // Returns one overlap, with what of its keyframes shows the same (MatchOverlap), as far as they
  // are still there.
  absl::StatusOr<OverlapInfo> GetOverlap(absl::string_view mission, uint64_t overlap) const;

  // Returns all islands, the reference island first.
  absl::StatusOr<std::vector<IslandView>> GlobalMapView(absl::string_view mission) const;
  // Returns the next piece of what changed since the watcher saw the map last, about `max_items`
  // keyframes and points; none when nothing has changed.
  absl::StatusOr<std::optional<MapChanges>> NextChanges(absl::string_view mission, size_t max_items,
                                                        MapWatcher& watcher) const;
  // Adds a listener that is called after each change; there may be several. Returns a token that
  // removes it.
  absl::StatusOr<uint64_t> AddMapListener(absl::string_view mission,
                                          std::function<void()> listener);
  void RemoveMapListener(absl::string_view mission, uint64_t token);
  // Returns the map's past, as far as the journal goes back: the map as it was then, then what
  // changed up to later revisions, up to now, in the pieces that a MapWatcher would be told. The
  // version of the last one is one of this store's. It takes as long as a backup. INVALID_ARGUMENT,
  // naming the field, for an option out of its range; RESOURCE_EXHAUSTED if it is too long;
  // CANCELLED once `goes_on`, which is called often, says no.
  absl::StatusOr<std::vector<MapChanges>> ReplayMap(absl::string_view mission,
                                                    const ReplayOptions& options,
                                                    const std::function<bool()>& goes_on) const;

  // Returns the first event after this number that is remembered; none if nothing has happened
  // since. 0, or a number that is newer than the store's: from the oldest on.
  absl::StatusOr<std::optional<MissionEvent>> EventAfter(absl::string_view mission,
                                                         uint64_t number) const;
  // These do as AddMapListener and RemoveMapListener; the listener is called after events.
  absl::StatusOr<uint64_t> AddEventListener(absl::string_view mission,
                                            std::function<void()> listener);
  void RemoveEventListener(absl::string_view mission, uint64_t token);

 private:
  struct Session {
    std::string agent;
    std::shared_ptr<Mission> mission;
  };

  // Returns the mission, for somebody who uses it: it stays in memory for as long as the caller
  // holds it.
  absl::StatusOr<std::shared_ptr<Mission>> FindMission(absl::string_view name) const;
  // The same, but waits for one that is asleep.
  absl::StatusOr<std::shared_ptr<Mission>> AwaitMission(absl::string_view name) const;
  // Has the directory know a mission of a shared journal that nobody has. NOT_FOUND: there is none.
  absl::Status TakeIn(absl::string_view name) const;
  // Makes the mission that a robot asks for in a shared journal, durably, unless it is there.
  absl::Status MakeShared(const SessionRequest& request);
  absl::Status WriteShared(const SessionRequest& request);
  // Learns which missions of the name other stores have deleted.
  absl::Status ReadDeparted(const std::string& name);
  void LoseMission(const std::string& name, const absl::Status& why);
  // Deletes missions that are asleep, whose retention has passed.
  void ExpireAsleep();
  MissionInfo Describe(const DirectoryMission& listed) const;
  absl::StatusOr<MissionInfo> GetShared(absl::string_view name) const;
  absl::StatusOr<std::vector<MissionInfo>> ListShared(absl::string_view after, size_t count) const;
  absl::Status CheckRoomForMission() const;
  // Keeps a new mission's name free of others until MissionDirectory::EndMaking.
  absl::Status ReserveName(const std::string& name);
  // Deletes the mission, if its retention has passed still.
  void Expire(const std::string& name) ABSL_LOCKS_EXCLUDED(deletion_mutex_, mutex_);
  // Deletes for good what was told of its end (Mission::Delete), after
  // MissionDirectory::BeginDeletion; `mission` is null if it is on the disk alone.
  absl::Status CheckNoSession(absl::string_view name, const Mission& mission) const
      ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status EndLife(absl::string_view name, const std::shared_ptr<Mission>& mission)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(deletion_mutex_) ABSL_LOCKS_EXCLUDED(mutex_);
  // Registers a session in the mission, which is made if there is none. Returns the session's id.
  absl::StatusOr<uint64_t> EnterMission(const SessionRequest& request);
  absl::StatusOr<OpenedSession> OpenSessionOf(const SessionRequest& request);
  // Returns ABORTED if the request is of a process that was in a mission that is deleted.
  absl::Status CheckNotDeparted(const SessionRequest& request) const;
  // Returns FAILED_PRECONDITION if the mission has another uid than this one, unless it is empty.
  absl::Status CheckUid(absl::string_view name, absl::string_view uid) const;
  // Returns the uid of a mission that is about to be made: the one that was promised of the name,
  // if that mission was not deleted, else a new one.
  std::string UidToBegin(const std::string& name) const;
  // Remembers who was in a mission that is about to go, before its name is free.
  void NoteDeparture(absl::string_view name);
  // Forgets the session, and the mission if nothing was ever written of it and nobody is in it.
  void LeaveMission(uint64_t session_id);
  // Wakes the fusion threads and the snapshot keeper, which may have work now.
  void Wake();
  std::shared_ptr<Mission> MakeMission(const std::string& name);
  // Makes a mission of which nothing was written; an empty uid: the one that was promised of the
  // name, else a new one.
  std::shared_ptr<Mission> BeginMission(const std::string& name, const std::string& uid);
  // Describes a mission that could not be read.
  MissionInfo InfoOfUnreadable(const std::string& name, const absl::Status& damage) const;
  absl::StatusOr<Session> FindSession(uint64_t session_id) const;
  MissionInfo Describe(const KnownMission& known) const;
  // Reads a mission that was asleep.
  absl::StatusOr<std::shared_ptr<Mission>> LoadEvicted(const std::string& name,
                                                       const EvictedMission& evicted);
  // Has the mission sleep from the start on, if the journal has a summary of it and fusion has
  // nothing to do; returns whether that is so.
  bool AddEvicted(const std::string& name);
  // Makes room in memory for so many more missions, if there is one that may sleep.
  void MakeRoomForMissions(size_t coming);
  bool sleeps_by_itself() const { return options_.sleep_after_s > 0; }
  void StartEviction();
  void EndEviction();

  const MapStoreOptions options_;
  const std::shared_ptr<const Vocabulary> vocabulary_;
  const std::unique_ptr<Journal> journal_;
  MissionLeases* const leases_;  // The journal's.
  const Clock clock_;
  const std::unique_ptr<MemoryBudget> memory_;
  const std::unique_ptr<MemoryReturner> memory_returner_;
  std::unique_ptr<FusionExecutor> executor_;
  std::unique_ptr<SnapshotKeeper> snapshots_;
  const std::unique_ptr<MissionTender> tender_;
  const std::unique_ptr<MissionTender> lease_keeper_;

  // Holds all missions.
  std::unique_ptr<MissionDirectory> directory_;
  const std::unique_ptr<DepartedMissions> departed_;
  const std::unique_ptr<PromisedUids> promised_uids_;
  std::unique_ptr<MissionEvictor> evictor_;
  std::unique_ptr<MissionLoader> loader_;
  std::atomic<uint64_t> woken_ = 0;
  std::atomic<int64_t> waking_ns_ = 0;

  UidListener uid_listener_;
  // Whoever makes a mission in a shared journal holds this.
  absl::Mutex making_mutex_;
  // Only the lease keeper uses these: robots are refused, as the journal is out of reach; what the
  // load was told of last.
  bool refuses_ = false;
  const std::unique_ptr<LoadMeter> load_meter_;
  absl::Time load_told_at_ = absl::InfinitePast();
  int tendings_ = 0;  // Only the tender uses it.
  // A deletion holds this lock from its beginning to its end.
  absl::Mutex deletion_mutex_;
  mutable absl::Mutex mutex_;
  ExpiryListener expiry_listener_ ABSL_GUARDED_BY(mutex_);
  std::map<uint64_t, Session> sessions_ ABSL_GUARDED_BY(mutex_);
  uint64_t next_session_ ABSL_GUARDED_BY(mutex_) = 1;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STORE_MAP_STORE_H_
