// Holds what others share, from its arrival until it lies in one local map of the robot.
#ifndef CORBSLAM_CLIENT_AGENT_LINK_SHARED_INBOX_H_
#define CORBSLAM_CLIENT_AGENT_LINK_SHARED_INBOX_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/link/map_jobs.h"
#include "client_agent/map/guarded_map.h"
#include "client_agent/map/own_correction.h"
#include "client_agent/shared/shared_map.h"
#include "slam/exchange/uplink.h"

namespace corbslam::client_agent {

// Bounds the updates that the mapping thread has not taken over yet. When one of the two is
// reached, the session reads on only once the mapping thread has taken them all: nothing is lost,
// the store waits.
struct InboxLimits {
  size_t max_updates = 1000;
  // About so many bytes of memory.
  size_t max_bytes = 64 << 20;
};

// Returns about how many bytes of memory an update takes.
size_t ApproximateBytes(const SharedUpdate& update);

// The inbox is thread-safe, but for what is said to be of the mapping thread. It lives in a
// shared_ptr.
class SharedInbox : public std::enable_shared_from_this<SharedInbox> {
 public:
  // Nothing is owned. `jobs` are those of the local map's writing thread. Neither `jobs` nor
  // `uplink` is used any more once Close has returned and that thread has ended.
  SharedInbox(LocalMapId local_map, MapJobs& jobs, Uplink& uplink, const InboxLimits& limits);

  // Takes in one update, and has the mapping thread place it soon.
  void Add(ArrivedUpdate update);
  // Takes in several, which are placed together.
  void AddAll(std::vector<ArrivedUpdate> updates);
  // Notes that the local map has ended: nothing is placed any more, and nothing keeps the session
  // from reading.
  void Close();

  // Places anew what others made, after the robot moved its own map. Called on the mapping thread,
  // outside of Read and Write.
  void Correct(const OwnCorrection& correction, GuardedMap& map);

  // Has the mapping thread give up what a foreign local map says (SharedMap::LeaveOut).
  void LeaveOut(LocalMapId foreign);

  LocalMapId local_map() const { return local_map_; }
  std::optional<Similarity3d> GlobalFromLocal() const;
  // Returns where the local map lay before its last correction for a pose that was found before it
  // (GuardedMap::corrections): a pose of one and the place of the other are off by all that was
  // corrected.
  std::optional<Similarity3d> GlobalFromLocal(uint64_t corrections) const;
  bool GlobalIsInMetres() const;
  // Returns how many keyframes of others are held.
  size_t keyframes() const;

 private:
  bool IsFull() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return updates_.size() >= limits_.max_updates || bytes_ >= limits_.max_bytes;
  }
  // Returns whether the session is not to read on.
  bool MustWait() const;
  // The next three are called on the mapping thread.
  std::vector<ArrivedUpdate> TakeArrived();
  void PlaceArrived(GuardedMap& map);
  // Plans while others read the map, too.
  void PlanAndPlace(GuardedMap& map);
  void Place(const PlacementPlan& plan, uint64_t corrections, Map& map);
  // Keeps where the local map lies now that it was corrected so often.
  void NotePlace(uint64_t corrections) ABSL_LOCKS_EXCLUDED(mutex_);

  const LocalMapId local_map_;
  MapJobs& jobs_;
  Uplink& uplink_;
  const InboxLimits limits_;
  SharedMap shared_;  // Used by the mapping thread alone.

  mutable absl::Mutex mutex_;
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<ArrivedUpdate> updates_ ABSL_GUARDED_BY(mutex_);
  size_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  std::optional<Similarity3d> global_from_local_ ABSL_GUARDED_BY(mutex_);
  std::optional<Similarity3d> before_correction_ ABSL_GUARDED_BY(mutex_);
  uint64_t corrections_ ABSL_GUARDED_BY(mutex_) = 0;  // Of the map that global_from_local_ is for.
  bool global_is_in_metres_ ABSL_GUARDED_BY(mutex_) = false;
  size_t keyframes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LINK_SHARED_INBOX_H_
