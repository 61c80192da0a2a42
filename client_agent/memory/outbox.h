// Batches that the map store has not acknowledged yet, in order, bounded in bytes.
#ifndef CORBSLAM_CLIENT_AGENT_MEMORY_OUTBOX_H_
#define CORBSLAM_CLIENT_AGENT_MEMORY_OUTBOX_H_

#include <deque>
#include <map>
#include <memory>
#include <vector>

#include "slam/exchange/map_update.h"
#include "slam/exchange/uplink.h"

namespace corbslam {

// Bytes that a batch takes, about, in memory and on the wire.
size_t ApproximateBytes(const MapUpdateBatch& batch);

// True if there is nothing in the batch to tell.
bool IsEmpty(const MapUpdateBatch& batch);

// Not thread-safe.
class Outbox {
 public:
  explicit Outbox(size_t max_bytes) : max_bytes_(max_bytes) {}

  // While false, changes wait (and coalesce) in the recorder.
  bool HasRoom() const { return bytes_ < max_bytes_; }
  bool IsEmpty() const { return batches_.empty(); }
  size_t bytes() const { return bytes_; }
  size_t size() const { return batches_.size(); }

  // Gives the batch its number and keeps it until it is acknowledged.
  void Push(MapUpdateBatch batch);
  // Drops what is stored. A number never given out is ignored.
  void Acknowledge(const Acknowledgement& acknowledgement);

  // The oldest batch not marked sent since the last Rewind, or null.
  std::shared_ptr<const MapUpdateBatch> NextUnsent() const;
  void MarkSent() { ++sent_; }
  void MarkUnsent() { sent_ -= sent_ > 0 ? 1 : 0; }
  // A new session sends everything again that is not acknowledged.
  void Rewind() { sent_ = 0; }

  // Local maps of which batches are held.
  std::vector<LocalMapId> local_maps() const;

 private:
  const size_t max_bytes_;
  std::deque<std::shared_ptr<const MapUpdateBatch>> batches_;
  size_t sent_ = 0;
  size_t bytes_ = 0;
  std::map<LocalMapId, uint64_t> last_number_;
};

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_MEMORY_OUTBOX_H_
