// Holds what others share, from its arrival until it lies in one local map of the robot.
#ifndef CORBSLAM_CLIENT_AGENT_LINK_SHARED_INBOX_H_
#define CORBSLAM_CLIENT_AGENT_LINK_SHARED_INBOX_H_

#include <cstddef>
#include <cstdint>
#include <limits>
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
  static constexpr uint64_t kNewest = std::numeric_limits<uint64_t>::max();

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

  // Places anew what others made, after the robot moved its own map and counted that. Called on the
  // mapping thread, outside of Read and Write.
  void Correct(const OwnCorrection& correction, GuardedMap& map);

  // Has the mapping thread give up what a foreign local map says (SharedMap::LeaveOut).
  void LeaveOut(LocalMapId foreign);

  LocalMapId local_map() const { return local_map_; }
  // Returns where the local map lies, for a pose that was found after so many corrections of it
  // (GuardedMap::corrections). Of before the last one that is where it lay then: a pose of before
  // and a place of after a correction are together off by twice as much.
  std::optional<Similarity3d> GlobalFromLocal(uint64_t corrections = kNewest) const;
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
  void Place(const PlacementPlan& plan, Map& map);

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
  // What it was before the last correction, for poses that were found after fewer than these.
  std::optional<Similarity3d> before_correction_ ABSL_GUARDED_BY(mutex_);
  uint64_t corrections_ ABSL_GUARDED_BY(mutex_) = 0;
  bool global_is_in_metres_ ABSL_GUARDED_BY(mutex_) = false;
  size_t keyframes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LINK_SHARED_INBOX_H_
