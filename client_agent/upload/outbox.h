// Keeps the batches that the map store has not acknowledged yet, in order. The oldest ones may lie
// in a spool, the newest are in memory, those between are in both.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_OUTBOX_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_OUTBOX_H_

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "client_agent/spool/spool.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/uplink.h"

namespace corbslam::client_agent {

// Returns true if there is nothing in the batch to tell.
bool IsEmpty(const MapUpdateBatch& batch);

// A local map that can't go on at the store, with the reason: DATA_LOSS or ALREADY_EXISTS.
struct LostLocalMap {
  LocalMapId id;
  bool of_earlier_process = false;
  absl::Status reason;
};

// The outbox only keeps account; whoever owns it moves the bytes. Not thread-safe.
class Outbox {
 public:
  struct Entry {
    LocalMapId local_map;
    uint64_t number = 0;
    std::shared_ptr<const MapUpdateBatch> batch;  // Null where the batch is in the spool alone.
    std::optional<SpooledBatch> spooled;
    size_t bytes = 0;  // Bytes of memory.
  };

  // With `marks_open` the newest acknowledged batch of each local map stays in the spool until the
  // local map is closed, so that the next process knows what is to be closed.
  explicit Outbox(size_t max_bytes, bool marks_open = false)
      : max_bytes_(max_bytes), marks_open_(marks_open) {}

  // Returns whether memory has room. While it has none, changes wait (and coalesce) in the
  // recorder. One batch always fits.
  bool HasRoom() const { return bytes_ == 0 || bytes_ < max_bytes_; }
  bool IsEmpty() const { return entries_.empty(); }
  size_t bytes() const { return bytes_; }
  size_t size() const { return entries_.size(); }
  // Returns what its batches take in the spool, those that are in memory, too, included.
  uint64_t SpooledBytes() const;

  // Notes that the agent begins a local map. Returns false if the id is taken.
  bool Begin(LocalMapId local_map) { return local_maps_.try_emplace(local_map).second; }
  // Adds a batch that an earlier process left, or a part of a local map's snapshot; the latter
  // come first. To be called before anything else. Returns DATA_LOSS where an
  // earlier batch of the local map is missing, so that this one can't be applied; it is left out.
  absl::Status AddFound(const SpooledBatch& spooled);
  // Goes on with a local map that an earlier process left: its batches stay in the spool when they
  // are acknowledged (AcknowledgedBatches). Returns false if there is no such local map, or it
  // can't go on.
  bool GoOnWith(LocalMapId local_map);
  // Has the batches of a local map that Begin began stay in the spool, too.
  void Keep(LocalMapId local_map);
  // The spool may drop the acknowledged batches of this local map.
  void StopKeeping(LocalMapId local_map);
  // Gives the batch its number and keeps it until it is acknowledged. A batch of a lost local map
  // is dropped.
  void Push(MapUpdateBatch batch);
  // Drops the batches that the store has. A number never given out is ignored.
  void Acknowledge(const Acknowledgement& acknowledgement);

  // Begins a new session: everything that is not acknowledged is sent again. An earlier process's
  // local maps get a last batch that closes them. Gives up and returns the local maps of which the
  // store does not have what it acknowledged before, and those of this process of which it has what
  // was never sent: their id is taken.
  std::vector<LostLocalMap> Resume(const SessionGrant& grant);
  // Gives up a local map: its batches go, and what is pushed later is dropped.
  void Drop(LocalMapId local_map);

  // Returns the oldest entry not marked sent since the last Resume, or null; valid until the next
  // change.
  const Entry* NextUnsent() const;
  // Returns the oldest entry where it is marked sent, else null.
  const Entry* OldestSent() const { return sent_ > 0 ? &entries_.front() : nullptr; }
  void MarkSent();
  void MarkUnsent() { sent_ -= sent_ > 0 ? 1 : 0; }

  // Returns the oldest batch that is in memory, or the oldest that is there alone; or null. Valid
  // until the next change.
  const Entry* OldestInMemory() const;
  const Entry* OldestUnwritten() const;
  // Notes that the batch is in the spool, too. Returns false if it was acknowledged or dropped
  // meanwhile.
  bool MarkWritten(const SpooledBatch& spooled);
  // Takes a batch that is in the spool out of memory, where the outbox still has it.
  void Evict(LocalMapId local_map, uint64_t number);
  // The disk may not have kept what the spool took after `order`: only memory has it.
  void MarkUnwritten(uint64_t order);
  // Returns the acknowledged batches of a local map that stay in the spool, in order.
  std::vector<SpooledBatch> AcknowledgedBatches(LocalMapId local_map) const;
  // Returns those of it that are not acknowledged, in order.
  std::vector<Entry> EntriesOf(LocalMapId local_map) const;
  // Has `snapshot` stand for the acknowledged batches up to its number.
  void ReplaceAcknowledged(LocalMapId local_map, const std::vector<SpooledBatch>& snapshot);
  // Returns the places in the spool that came to be needed no more since the last call.
  std::vector<SpooledBatch> TakeReleased() { return std::exchange(released_, {}); }

  // Returns the local maps to be named when a session opens: all that are not closed and
  // acknowledged.
  std::vector<LocalMapId> local_maps() const;
  // Returns the local map of the oldest entry; none when the outbox is empty.
  std::optional<LocalMapId> OldestLocalMap() const;
  bool IsOfEarlierProcess(LocalMapId local_map) const;
  // Returns the number of the local map's last batch; 0: there was none.
  uint64_t LastNumber(LocalMapId local_map) const;

 private:
  struct LocalMapNumbers {
    uint64_t last = 0;          // The last number given out.
    uint64_t sent = 0;          // The last number that this process sent.
    uint64_t acknowledged = 0;  // The store has acknowledged at least this number.
    bool of_earlier_process = false;
    bool closed = false;
    bool lost = false;
    bool keeps = false;
    bool goes_on = false;
    uint64_t found = 0;  // Where it goes on: the last number that the spool had.
    // In the spool and acknowledged.
    std::vector<SpooledBatch> acknowledged_batches;
  };

  absl::Status CheckState(LocalMapId id, const LocalMapNumbers& numbers, uint64_t stored) const;
  void CloseEarlier(LocalMapId id, uint64_t stored, LocalMapNumbers& numbers);
  template <typename Goes>
  void DropEntries(const Goes& goes);
  // Drops the local map's batches up to this one of them, in a time that does not grow with all
  // that waits.
  void DropAcknowledged(LocalMapId local_map, uint64_t number, LocalMapNumbers& numbers);
  // Looks at `likely` first, which may be null: a search goes through all that waits.
  Entry* Find(LocalMapId local_map, uint64_t number, const Entry* likely);
  void KeepOrRelease(LocalMapNumbers& numbers, const SpooledBatch& spooled);
  void ReleaseAcknowledged(LocalMapNumbers& numbers);

  const size_t max_bytes_;
  const bool marks_open_;
  std::deque<Entry> entries_;
  size_t sent_ = 0;
  size_t bytes_ = 0;
  std::map<LocalMapId, LocalMapNumbers> local_maps_;
  std::vector<SpooledBatch> released_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_OUTBOX_H_
