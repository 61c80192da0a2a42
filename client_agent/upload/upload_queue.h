// Holds what waits for the map store: the outbox, bounded in memory, and the spool that takes its
// oldest batches when the bound is reached.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_UPLOAD_QUEUE_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_UPLOAD_QUEUE_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/spool/spool.h"
#include "client_agent/upload/held_back.h"
#include "client_agent/upload/outbox.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/uplink.h"

namespace corbslam::client_agent {

struct UploadStatus {
  size_t batches = 0;
  uint64_t memory_bytes = 0;
  uint64_t spool_bytes = 0;
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
};

// The queue is thread-safe. The calls of the second group may wait for the disk and are to be made
// by one thread at a time; the others never do: no lock is held while the disk works.
class UploadQueue {
 public:
  // `spool` may be null. What it found is sent first.
  UploadQueue(size_t max_memory_bytes, std::unique_ptr<Spool> spool);

  // Does what Outbox::Begin does.
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
  bool HasUnsent() const;
  std::vector<LocalMapId> local_maps() const;
  UploadStatus status() const;

  void MarkUnsent();

  // Moves the oldest batches to the spool while there are more in memory than allowed, and gives
  // back room in the spool. An error is in the status.
  void Spill();
  // Moves all batches to the spool, for the next process.
  void SpillAll();
  // Returns the next batch to send, marked as sent, or null if there is none. Local maps that the
  // disk has not kept are added to `lost`.
  std::shared_ptr<const MapUpdateBatch> TakeUnsent(std::vector<LostLocalMap>& lost);

 private:
  bool SpillOldest(size_t allowed_bytes);
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

  const size_t max_memory_bytes_;
  const std::unique_ptr<Spool> spool_;  // Used by the calls of the second group alone.

  mutable absl::Mutex mutex_;
  Outbox outbox_ ABSL_GUARDED_BY(mutex_);
  std::optional<Suspect> suspect_ ABSL_GUARDED_BY(mutex_);
  uint64_t spool_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Status room_ ABSL_GUARDED_BY(mutex_);
  absl::Status loss_ ABSL_GUARDED_BY(mutex_);
  int lost_local_maps_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_UPLOAD_QUEUE_H_
