// Finds the keyframes of the robot's map, own and shared, by what they look like.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_PLACE_INDEX_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_PLACE_INDEX_H_

#include <memory>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/container/btree_set.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/map/guarded_map.h"
#include "slam/place/keyframe_database.h"

namespace corbslam::client_agent {

// The index is thread-safe; no lock is held across a call to the map.
class PlaceIndex {
 public:
  explicit PlaceIndex(const GuardedMap* map) : map_(*map) {}

  void Add(KeyframeId id, std::shared_ptr<const Words> words);
  void Remove(KeyframeId id);

  // Returns candidates for relocalisation, best first.
  std::vector<KeyframeId> Find(const Words& words) const;

  // Returns candidates for loops: one a group of covisible candidates, best first, none of
  // `excluded`; only those that look at least as much like the query as its own neighbours do at
  // worst (ORB-SLAM, T-RO 2015, VII.A).
  std::vector<KeyframeId> FindLoops(const Keyframe& query,
                                    const absl::btree_set<KeyframeId>& excluded) const;

 private:
  std::vector<KeyframeId> BestOfGroups(const std::vector<PlaceCandidate>& candidates) const;
  double LeastNeighbourScore(const Keyframe& query) const;

  const GuardedMap& map_;
  mutable absl::Mutex mutex_;
  KeyframeDatabase database_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_PLACE_INDEX_H_
