// Keeps what is known of batches that were sent and are not acknowledged.
#ifndef CORBSLAM_SERVICES_OBSERVE_PENDING_BATCHES_H_
#define CORBSLAM_SERVICES_OBSERVE_PENDING_BATCHES_H_

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "slam/exchange/uplink.h"

namespace corbslam::services {

// Returns what was noted of a batch once the batch was sent and is acknowledged, whichever is heard
// first. A batch that is sent again is noted anew. Not thread-safe.
template <typename Note>
class PendingBatches {
 public:
  // Notes a batch. Returns the notes of all batches that are acknowledged already.
  std::vector<Note> Sent(LocalMapId local_map, uint64_t number, Note note) {
    LocalMapNotes& notes = local_maps_[local_map];
    notes.sent.insert_or_assign(number, std::move(note));
    return TakeUpTo(notes.acknowledged, notes);
  }

  std::vector<Note> Acknowledged(const Acknowledgement& acknowledgement) {
    LocalMapNotes& notes = local_maps_[acknowledgement.local_map];
    // A store that lost what it had acknowledges less than before: later acknowledgements count
    // anew.
    notes.acknowledged = acknowledgement.number;
    return TakeUpTo(acknowledgement.number, notes);
  }

 private:
  struct LocalMapNotes {
    uint64_t acknowledged = 0;
    std::map<uint64_t, Note> sent;  // The key is the batch's number.
  };

  static std::vector<Note> TakeUpTo(uint64_t number, LocalMapNotes& notes) {
    std::vector<Note> ready;
    const auto end = notes.sent.upper_bound(number);
    for (auto it = notes.sent.begin(); it != end; ++it) ready.push_back(std::move(it->second));
    notes.sent.erase(notes.sent.begin(), end);
    return ready;
  }

  std::map<LocalMapId, LocalMapNotes> local_maps_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_PENDING_BATCHES_H_
