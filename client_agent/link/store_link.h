// The robot's memory management (CORB-SLAM, section 2.1): keeps its map and the map store's in
// step, both ways. Tracking and mapping never wait for it.
#ifndef CORBSLAM_CLIENT_AGENT_LINK_STORE_LINK_H_
#define CORBSLAM_CLIENT_AGENT_LINK_STORE_LINK_H_

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "client_agent/link/backoff.h"
#include "client_agent/link/localised_outbox.h"
#include "client_agent/link/map_jobs.h"
#include "client_agent/link/no_uplink.h"
#include "client_agent/link/picture_outbox.h"
#include "client_agent/link/share_anew.h"
#include "client_agent/link/share_watch.h"
#include "client_agent/link/shared_inbox.h"
#include "client_agent/map/guarded_map.h"
#include "client_agent/spool/spool.h"
#include "client_agent/upload/frame_inbox.h"
#include "client_agent/upload/held_back.h"
#include "client_agent/upload/link_budget.h"
#include "client_agent/upload/spooled_map.h"
#include "client_agent/upload/update_recorder.h"
#include "client_agent/upload/upload_queue.h"
#include "slam/exchange/uplink.h"

namespace corbslam::client_agent {

constexpr absl::Duration kReportEvery = absl::Seconds(4);

struct StoreLinkOptions {
  std::string mission;
  std::string agent;
  // The camera that recorded the pictures of every local map, to be told to the store. Nullopt:
  // nobody said it.
  std::optional<RecordedCamera> recorded_camera;
  // The features of a keyframe that go up.
  FeatureSelection features = {};
  // Becomes RecorderOptions::hold_newest.
  size_t hold_newest_keyframes = RecorderOptions().hold_newest;
  // Where no frame has come for so long, nothing is held back.
  absl::Duration max_hold = absl::Seconds(2);
  // What the store is asked to tell of what others mapped.
  ShareScope share = {};
  // The robot changes nothing: no local map is told, only where frames were (AddLocalised).
  bool localise_only = false;
  // The options from here on change speed, but no results.
  // Bytes that the outbox may take in memory; with a spool, what is over goes to the disk.
  size_t max_outbox_bytes = 64 << 20;
  // Bounds what others share and the mapping thread has not taken over yet.
  InboxLimits inbox;
  size_t max_keyframes_per_batch = 8;
  absl::Duration flush_interval = absl::Milliseconds(400);
  // Applies while batches wait that could not be sent: the next one is made when it is full or when
  // the last is this old, so that light updates coalesce.
  absl::Duration backlog_flush_interval = absl::Seconds(5);
  absl::Duration min_backoff = absl::Milliseconds(200);
  absl::Duration max_backoff = absl::Seconds(10);
  // The same for a store that refuses this agent: whoever set its keys or lists wrong sets them
  // right again.
  absl::Duration min_refused_backoff = absl::Seconds(10);
  absl::Duration max_refused_backoff = absl::Minutes(2);
  // Bounds of the link to the store; 0: no bound. Upwards, what the budget does not have waits in
  // the map and coalesces there; downwards, the store is asked to keep to it.
  uint64_t uplink_bytes_per_second = 0;
  uint64_t downlink_bytes_per_second = 0;
  // With a spool: all that is mapped is with the operating system after a quarter of this; the
  // spool's own syncing adds to that (SpoolOptions::sync). 0: the spool takes what memory has no
  // room for, and what is left at the end.
  absl::Duration spool_within = absl::ZeroDuration();
  // With spool_within: the local map in use stays in the spool, and open at the end, so that the
  // next process can go on with it.
  bool resumable = false;
  uint64_t seed = 1;           // Seed of the back-off's jitter.
  LinkEventListener on_event;  // Null: nobody listens.
  // Returns what the robot says of itself, which goes to a store that takes it whenever the
  // activity changes, and every kReportEvery; null: nothing does.
  std::function<AgentReport()> report;
  std::function<absl::Time()> clock = &absl::Now;
};

// Computes the words of a foreign keyframe. Called on the uplink's thread, among others.
using ComputeWords =
    std::function<std::shared_ptr<const Words>(const std::vector<Descriptor>& descriptors)>;

// The link is thread-safe. Without Start it has no thread, and Step does its work (deterministic
// runs).
class StoreLink : private UplinkListener {
 public:
  // `uplink` is not owned. Where it is null, nothing is sent, and changes are recorded for the
  // spool alone. `spool` may be null; what it found goes up first, and what could not be sent is in
  // it at the end. `goes_on` is a local map that it found and that is begun again; invalid: none
  // is.
  StoreLink(const StoreLinkOptions& options, Uplink* uplink, ComputeWords compute_words,
            std::unique_ptr<Spool> spool = nullptr, LocalMapId goes_on = {});
  ~StoreLink() override;
  StoreLink(const StoreLink&) = delete;
  StoreLink& operator=(const StoreLink&) = delete;

  // Says whether the threads of the local maps before still write them.
  enum class Earlier { kHaveEnded, kMayStillBeWritten };

  // Begins a local map, whose changes are recorded from now on. Those before are told to their end
  // and closed: at once, or each after EndLocalMap. `map` is read while Reads says so, `jobs` are
  // used until the next local map begins; neither is owned. `spooled_map` is what `map` was made of
  // where it is the one that goes on, else null.
  void BeginLocalMap(GuardedMap& map, MapJobs& jobs, const SpooledMap* spooled_map = nullptr,
                     Earlier earlier = Earlier::kHaveEnded);
  // Says that the local map is written no more.
  void EndLocalMap(LocalMapId local_map);
  // Returns false once all that there is to tell of the local map lies in batches, or it is given
  // up.
  bool Reads(LocalMapId local_map) const;

  // Places anew what others made, after the robot moved its own map. Called on the writing thread,
  // outside of Read and Write.
  void OnCorrected(LocalMapId local_map, const OwnCorrection& correction, GuardedMap& map);
  void AddTrackedFrame(const TrackedFrame& frame);
  void AddLostFrame(int64_t timestamp_ns);
  // Takes what the robot itself brings back of its earlier local maps, as if the store had shared
  // it; nothing where another local map is in use by now. Computes words, as OnShared does.
  void Share(LocalMapId for_local_map, SharedUpdate update);
  // Asks the store to tell anew what others made within `radius_m` of the robot. When that is here,
  // all else that others made goes; until then the robot has what it had. Does nothing while no
  // session stands, or while it waits for that.
  void AskAnew(double radius_m);
  // Does what UploadQueue::ReadLocalMap does, for a local map that Reads says is told.
  absl::StatusOr<SpooledMap> ReadTold(LocalMapId local_map) {
    return queue_.ReadLocalMap(local_map);
  }
  // Takes where a frame was of a robot that localises only; what AddTrackedFrame and AddLostFrame
  // take is its trajectory.
  void AddLocalised(const LocalisedFrame& frame);
  // Takes what a keyframe's camera saw, to be sent once the keyframe was and the link has time.
  void AddPicture(KeyframePicture picture) { pictures_.Add(std::move(picture)); }
  // Returns false if pictures would go nowhere, as far as is known.
  bool WantsPictures() const { return has_link_ && !options_.localise_only && pictures_.Wants(); }
  PictureOutbox::Counts pictures() const { return pictures_.counts(); }

  // Changes StoreLinkOptions::uplink_bytes_per_second.
  void SetUplinkRate(uint64_t bytes_per_second) { budget_.SetRate(bytes_per_second); }
  // Changes StoreLinkOptions::share: the session is opened again to say so.
  void SetShare(const ShareScope& share);

  void Start();
  // Sends all there is, now; with a budget, as much as that has.
  void Step();
  // Closes the local map, and returns when everything is acknowledged, however long a budget makes
  // that. Else returns DEADLINE_EXCEEDED, which says what is left, or the reason for which the
  // store refuses this agent (which is not waited for), or for which the local map in use could not
  // go on (DATA_LOSS, ALREADY_EXISTS). Without an uplink, returns when the spool has everything, or
  // why it has not.
  absl::Status Finish(absl::Duration timeout);

  // Gives up what one of others' local maps says, in the robot's local map in use and in all that
  // come (SharedMap::LeaveOut), and tells the store why.
  void LeaveOut(const MapContradiction& found);

  // Returns where the robot's frame is in the global one; none before fusion.
  // `corrections` are as SharedInbox has them.
  std::optional<Similarity3d> GlobalFromLocal(uint64_t corrections = SharedInbox::kNewest) const;
  // Returns whether the store said that the global frame is in metres.
  bool GlobalIsInMetres() const;
  // Returns when the first keyframe was acknowledged.
  std::optional<absl::Time> first_acknowledged() const;
  // Returns true if the local map can't go on at the store (it lost what it had acknowledged, or
  // the id is taken). What is new in it is told to nobody; the agent should begin another one.
  bool NeedsNewLocalMap() const;
  UploadStatus upload() const;
  size_t shared_keyframes() const;
  // Returns how many shared updates came in the session that stands, or in the last one.
  uint64_t shared_updates() const;

 private:
  struct Recording {
    GuardedMap* map = nullptr;
    std::unique_ptr<UpdateRecorder> recorder;
    bool closing = false;
    bool asked_for_exact_places = false;
    bool closed = false;      // True: its last batch is in the outbox.
    bool stays_open = false;  // True: its last batch does not close it.
    // UpdateRecorder::held_back_changes of what the spool has; nullopt: of nothing.
    std::optional<uint64_t> held_back;
  };
  void OnSessionOpened(const SessionGrant& grant) override;
  void OnAcknowledged(const Acknowledgement& acknowledgement) override;
  void OnLocalisedKept(const LocalisedKept& spooled_map) override;
  void OnShared(SharedUpdate update) override;
  void OnExactPlacesWanted() override;
  void OnSessionClosed(const absl::Status& reason) override;

  void NoteClosed(const absl::Status& reason) ABSL_LOCKS_EXCLUDED(mutex_);
  void NoteRefusal(const absl::Status& reason) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  ArrivedUpdate Prepare(SharedUpdate update) const;
  void Tell(LinkEvent event, LocalMapId local_map) const ABSL_LOCKS_EXCLUDED(mutex_);
  void Run();
  bool WaitForWork();
  void NoteCapabilities(const Capabilities& store) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void ConnectIfDue();
  // Takes over what was told anew, if it has been waited for long enough.
  void PlaceAnew();
  // Gives the recorders the frames that tracking has added.
  void DeliverFrames() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void TakeBatches(bool all);
  bool TakeBatchOf(Recording& recording);
  // Writes what is in no batch yet to the spool, where all is to outlive the process: now, or when
  // it is due.
  void WriteHeldBack(bool now);
  void WriteHeldBackOf(Recording& recording, bool anew);
  bool WritesAll() const {
    return queue_.has_spool() && options_.spool_within > absl::ZeroDuration();
  }
  // Moves to the disk what is to be there.
  void SpillDue(bool now);
  bool IsToldWithoutLink() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Lets go of local maps that were told to their end; they are read no more.
  void LetGoOfClosed();
  std::shared_ptr<SharedInbox> CurrentInbox() const;
  // Returns whether the budget holds now. While no session stands, a spool takes what comes: it is
  // there for what a process that dies would lose.
  bool IsBudgeted() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void NoteHeldBack() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  UplinkHold FindHold() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  std::string DescribeWhatIsLeft() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void SendUnsent();
  void SendLocalised(bool all);
  void SendPictures();
  // Gives pictures that may be sent now a moment to go: nobody will send them later.
  void AwaitPictures(absl::Duration timeout) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Sends what the robot says of itself, if that is due.
  void SendReport();
  void BeginLocalised(const Capabilities& store) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Gives up local maps. Those of this process get no more batches.
  void GiveUp(const std::vector<LostLocalMap>& lost) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Returns true if no local map goes on.
  bool IsFinishing() const;
  bool IsDone() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Returns whether no batch of it was made yet.
  bool HasNoBatch(const Recording& recording) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool BeginsInSpool(const Recording& recording) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Returns whether the local map is being recorded, and the store can't know of it yet.
  bool IsUnknownToStore(LocalMapId local_map) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool FlushIsDue() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const StoreLinkOptions options_;
  NoUplink no_uplink_;
  const bool has_link_;
  // Null: nothing is recorded.
  Uplink* const uplink_;
  const ComputeWords compute_words_;
  // The queue may be called with mutex_ held, but for the calls that wait for the disk.
  UploadQueue queue_;
  LinkBudget budget_;
  FrameInbox frames_;
  LocalisedOutbox localised_;
  PictureOutbox pictures_;

  mutable absl::Mutex mutex_;
  std::vector<std::unique_ptr<Recording>> recordings_ ABSL_GUARDED_BY(mutex_);
  std::shared_ptr<SharedInbox> inbox_ ABSL_GUARDED_BY(mutex_);
  std::vector<MapContradiction> left_out_ ABSL_GUARDED_BY(mutex_);
  size_t reported_left_out_ ABSL_GUARDED_BY(mutex_) = 0;
  ShareAnew anew_ ABSL_GUARDED_BY(mutex_);
  ShareScope share_ ABSL_GUARDED_BY(mutex_);        // What is asked for now.
  ShareWatch share_watch_ ABSL_GUARDED_BY(mutex_);  // Of the local map in use.
  // With kOver the mission is there no more, and none is opened again.
  enum class Session { kNone, kOpening, kOpen, kOver };
  Session session_ ABSL_GUARDED_BY(mutex_) = Session::kNone;
  // Why the store refused the last session, or ended it so; OK: it did not.
  absl::Status refusal_ ABSL_GUARDED_BY(mutex_);
  absl::Status closed_ ABSL_GUARDED_BY(mutex_);  // Why the last session or attempt ended.
  absl::Time next_attempt_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  absl::Time last_flush_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  // They count attempts since something was acknowledged, or since a session lasted.
  Backoff backoff_ ABSL_GUARDED_BY(mutex_);
  Backoff refused_backoff_ ABSL_GUARDED_BY(mutex_);
  // SessionGrant::mission_uid of the first session that had one.
  std::string mission_uid_ ABSL_GUARDED_BY(mutex_);
  absl::Time opened_ ABSL_GUARDED_BY(mutex_) = absl::InfiniteFuture();
  bool needs_new_local_map_ ABSL_GUARDED_BY(mutex_) = false;
  // Refused items of local maps that are not read any more.
  uint64_t refused_items_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t last_revision_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t shared_updates_ ABSL_GUARDED_BY(mutex_) = 0;  // Of this session.
  // Whether the last session's store moves points with their keyframes.
  bool store_moves_points_ ABSL_GUARDED_BY(mutex_) = true;
  bool told_not_kept_ ABSL_GUARDED_BY(mutex_) = false;
  bool reopen_ ABSL_GUARDED_BY(mutex_) = false;
  // Whether this session's store takes reports, what the last one said, and when the next one is
  // due.
  bool store_takes_reports_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<AgentActivity> reported_ ABSL_GUARDED_BY(mutex_);
  absl::Time next_report_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  HeldBackWatch held_back_ ABSL_GUARDED_BY(mutex_);
  // Under a budget, counts whose turn it is among the local maps that are told.
  size_t turn_ ABSL_GUARDED_BY(mutex_) = 0;
  bool wake_ ABSL_GUARDED_BY(mutex_) = false;
  bool stop_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<absl::Time> first_acknowledged_ ABSL_GUARDED_BY(mutex_);
  // Used by the thread that makes batches alone.
  absl::Time next_held_back_ = absl::InfinitePast();
  std::thread thread_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LINK_STORE_LINK_H_
