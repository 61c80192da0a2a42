// Keeps the batches that the map store has not acknowledged yet, in order. The oldest ones may lie
// in a spool, the others are in memory.
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
    std::shared_ptr<const MapUpdateBatch> batch;  // Null where the batch is in the spool.
    SpooledBatch spooled;
    size_t bytes = 0;  // Bytes of memory.
  };

  explicit Outbox(size_t max_bytes) : max_bytes_(max_bytes) {}

  // Returns whether memory has room. While it has none, changes wait (and coalesce) in the
  // recorder. One batch always fits.
  bool HasRoom() const { return bytes_ == 0 || bytes_ < max_bytes_; }
  bool IsEmpty() const { return entries_.empty(); }
  size_t bytes() const { return bytes_; }
  size_t size() const { return entries_.size(); }

  // Notes that the agent begins a local map. Returns false if the id is taken.
  bool Begin(LocalMapId local_map) { return local_maps_.try_emplace(local_map).second; }
  // Adds a batch that an earlier process left; to be called before anything else. Returns DATA_LOSS
  // where an earlier batch of the local map is missing, so that this one can't be applied; it is
  // left out.
  absl::Status AddFound(const SpooledBatch& spooled);
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

  // Returns the oldest batch in memory, or null.
  std::shared_ptr<const MapUpdateBatch> OldestInMemory() const;
  // Notes that the batch is in the spool now. Returns false if it was acknowledged or dropped
  // meanwhile.
  bool MarkSpilled(const SpooledBatch& spooled);
  // Returns the places in the spool that came to be needed no more since the last call.
  std::vector<SpooledBatch> TakeReleased() { return std::exchange(released_, {}); }

  // Returns the local maps to be named when a session opens: all that are not closed and
  // acknowledged.
  std::vector<LocalMapId> local_maps() const;
  // Returns the local map of the oldest entry; none when the outbox is empty.
  std::optional<LocalMapId> OldestLocalMap() const;
  bool IsOfEarlierProcess(LocalMapId local_map) const;

 private:
  struct LocalMapNumbers {
    uint64_t last = 0;          // The last number given out.
    uint64_t sent = 0;          // The last number that this process sent.
    uint64_t acknowledged = 0;  // The store has acknowledged at least this number.
    bool of_earlier_process = false;
    bool closed = false;
    bool lost = false;
  };

  absl::Status CheckState(LocalMapId id, const LocalMapNumbers& numbers, uint64_t stored) const;
  void CloseEarlier(LocalMapId id, uint64_t stored, LocalMapNumbers& numbers);
  template <typename Goes>
  void DropEntries(const Goes& goes);

  const size_t max_bytes_;
  std::deque<Entry> entries_;
  size_t sent_ = 0;
  size_t bytes_ = 0;
  std::map<LocalMapId, LocalMapNumbers> local_maps_;
  std::vector<SpooledBatch> released_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_OUTBOX_H_
