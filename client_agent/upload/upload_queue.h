// Holds what waits for the map store: the outbox, bounded in memory, and the spool, which takes all
// batches as they are made, or only the oldest when the bound is reached.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_UPLOAD_QUEUE_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_UPLOAD_QUEUE_H_

#include <cstdint>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/spool/spool.h"
#include "client_agent/upload/held_back.h"
#include "client_agent/upload/held_back_items.h"
#include "client_agent/upload/outbox.h"
#include "client_agent/upload/spooled_map.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/uplink.h"

namespace corbslam::client_agent {

// Why what waits for the map store does not go up.
enum class UplinkHold {
  kNone,     // A session stands: it goes up, as fast as store and link take it.
  kOpening,  // A session was asked for and is not granted: the store reads a mission that slept.
  kAway,     // Nobody answers.
  kNoRoom,   // The store refuses: a limit of the mission, of its disk or of its memory.
  kRefused,  // The store refuses for another reason.
};
constexpr size_t kUplinkHolds = 5;

struct UploadStatus {
  size_t batches = 0;
  uint64_t memory_bytes = 0;
  uint64_t spool_bytes = 0;
  // How often the disk was made to keep what the spool has.
  uint64_t spool_syncs = 0;
  // Why the newest batches would not outlive the process, though they should: the disk is full, or
  // fails.
  absl::Status durable;
  // RESOURCE_EXHAUSTED: neither memory nor disk has room, and changes wait in the map. UNAVAILABLE:
  // the disk fails.
  absl::Status room;
  // DATA_LOSS or ALREADY_EXISTS: why the last lost local map had to be given up.
  absl::Status loss;
  int lost_local_maps = 0;
  // Items with impossible values, which were kept out of batches; the queue doesn't know them.
  uint64_t refused_items = 0;
  // What is in no batch yet. The queue doesn't know it; the link fills it in.
  HeldBack held_back;
  // Frames of the trajectory of a robot that only localises, which the store has not said it keeps.
  size_t frames = 0;
  // Why nothing goes up at the moment.
  UplinkHold hold = UplinkHold::kNone;
};

struct UploadQueueOptions {
  size_t max_memory_bytes = 64 << 20;
  // True: the spool takes every batch as soon as it is pushed, and none leaves memory before.
  bool write_all = false;
  // True: the local maps of this process stay in the spool, acknowledged or not, until they are
  // closed, and nothing is sent before it is on the disk for certain. Needs write_all.
  bool keep = false;
  // A local map that an earlier process left and that goes on; invalid: none does.
  LocalMapId goes_on = {};
  // With keep: when the acknowledged batches in the spool take so much more than twice what the
  // last snapshot of the local map took, a new one is written in their place.
  uint64_t snapshot_after_bytes = 8 << 20;
  // True: that is done by whoever calls Spill, who waits for it.
  bool snapshot_at_once = false;
};

// The queue is thread-safe. The calls of the second group may wait for the disk and are to be made
// by one thread at a time; the others never do: no lock is held while the disk works.
class UploadQueue {
 public:
  // `spool` may be null. What it found is sent first.
  UploadQueue(const UploadQueueOptions& options, std::unique_ptr<Spool> spool);
  UploadQueue(size_t max_memory_bytes, std::unique_ptr<Spool> spool)
      : UploadQueue(UploadQueueOptions{.max_memory_bytes = max_memory_bytes}, std::move(spool)) {}

  // Does what Outbox::Begin does. The local map that goes on is there already. What is kept of
  // others need not be any more.
  bool Begin(LocalMapId local_map);
  void Push(MapUpdateBatch batch);
  void Acknowledge(const Acknowledgement& acknowledgement);
  // Does what Outbox::Resume does; lost local maps are in the log and in the status.
  std::vector<LostLocalMap> Resume(const SessionGrant& grant);
  // Notes that the store finds the oldest batch to be no good. If an earlier process made it, gives
  // up its local map and returns true.
  bool GiveUpEarlier(const absl::Status& reason);
  // Notes that the store ended a session because of a batch. An earlier process's is given up as
  // above. This process's oldest one is suspected: where the next session begins with it again, the
  // store did not take it, and Resume gives up its local map. Returns false if nothing was sent
  // that the store could mean.
  bool NoteRefusal(const absl::Status& reason);

  bool has_spool() const { return spool_ != nullptr; }
  bool HasRoom() const;
  bool IsEmpty() const;
  // Returns whether the spool has all batches for certain.
  bool IsOnDisk() const;
  bool HasUnsent() const;
  std::vector<LocalMapId> local_maps() const;
  UploadStatus status() const;

  void MarkUnsent();
  // Makes a local map of all its batches, which neither the store nor anybody else has taken yet.
  // May wait for the disk, and may be called beside all else. Errors are ReadSpooledMap's.
  absl::StatusOr<SpooledMap> ReadLocalMap(LocalMapId local_map);

  // Writes what is to be written to the spool, moves the oldest batches there while there are more
  // in memory than allowed, and gives back room. An error is in the status.
  void Spill();
  // Moves all batches to the spool, for the next process. Returns whether it has them all.
  bool SpillAll();
  // Returns whether the local map has a batch.
  bool HasBegun(LocalMapId local_map) const;
  // Has the spool keep what a local map holds back, in place of what was held back before. Returns
  // how many bytes that took; nullopt: the disk did not take it, or the batches before it, or there
  // is no batch yet, which alone says what camera took the keyframes.
  std::optional<uint64_t> WriteHeldBack(const HeldBackItems& held_back);
  // Nothing is held back of the local map any more.
  void ReleaseHeldBack(LocalMapId local_map);
  // Returns true, once, where the disk may have lost what was held back.
  bool TakeHeldBackLost() { return std::exchange(held_back_lost_, false); }

  // Returns the next batch to send, marked as sent, or null if there is none. Local maps that the
  // disk has not kept are added to `lost`.
  std::shared_ptr<const MapUpdateBatch> TakeUnsent(std::vector<LostLocalMap>& lost);

 private:
  bool WriteOldest();
  void WriteAll();
  bool SpillOldest(size_t allowed_bytes);
  // Writes a batch where it was not, and syncs. Returns why the disk does not have it for certain.
  absl::Status KeepOnDisk(const Outbox::Entry& entry);
  void TakeSyncError();
  // Where the disk has no room, gives up that local maps can go on after a restart.
  bool GiveUpAcknowledged();
  void NoteDurable(const absl::Status& durable);
  // Makes a snapshot of the acknowledged batches of the local map in use, on a thread of its own.
  using Snapshot = absl::StatusOr<std::vector<MapUpdateBatch>>;
  void KeepSnapshot();
  void BeginSnapshot();
  void WriteSnapshot(Snapshot snapshot);
  bool MaySend(const Outbox::Entry& entry) const;
  void ReleaseSpooled();
  // The batch that was the oldest when the store ended a session, and the reason it gave.
  struct Suspect {
    LocalMapId local_map;
    uint64_t number = 0;
    absl::Status reason;
  };
  std::optional<LostLocalMap> GiveUpSuspect() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void NoteLoss(const LostLocalMap& lost) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void NoteSpool(const absl::Status& room);

  const UploadQueueOptions options_;
  const std::unique_ptr<Spool> spool_;  // Used by the calls of the second group alone.

  // Used by the calls of the second group alone.
  std::map<LocalMapId, HeldBackWriter> held_back_;
  // The snapshot that is being made: of which local map, up to which batch.
  struct MakingSnapshot {
    LocalMapId local_map;
    uint64_t number = 0;
    std::vector<SpooledBatch> written;  // Waits until it is on the disk.
    std::future<Snapshot> future;
  };
  std::optional<MakingSnapshot> snapshot_;
  uint64_t snapshot_bytes_ = 0;  // What the last one took.
  bool held_back_lost_ = false;

  mutable absl::Mutex mutex_;
  Outbox outbox_ ABSL_GUARDED_BY(mutex_);
  std::optional<Suspect> suspect_ ABSL_GUARDED_BY(mutex_);
  uint64_t spool_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t spool_syncs_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Status durable_ ABSL_GUARDED_BY(mutex_);
  absl::Status room_ ABSL_GUARDED_BY(mutex_);
  LocalMapId in_use_ ABSL_GUARDED_BY(mutex_);
  absl::Status loss_ ABSL_GUARDED_BY(mutex_);
  int lost_local_maps_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_UPLOAD_QUEUE_H_
