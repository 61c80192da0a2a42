// Mirrors the observations that the map store has been told, so that only differences travel.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_OBSERVATION_MIRROR_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_OBSERVATION_MIRROR_H_

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "slam/exchange/map_update.h"
#include "slam/map/map.h"

namespace corbslam::client_agent {

// The mirror follows the same rules as Map, so that it stays equal to the store's side. Not
// thread-safe.
class ObservationMirror {
 public:
  void AddKeyframe(KeyframeId id, size_t keypoints);
  void RemoveKeyframe(KeyframeId id);
  void RemovePoint(MapPointId id);
  void ReplacePoint(MapPointId replaced, MapPointId survivor);
  // Takes what was told elsewhere, as the map store takes it: an observation goes where its point or
  // its keypoint has another one. Returns false, and does nothing, for an unknown keyframe or
  // keypoint.
  bool Apply(const ObservationChange& change);

  // Returns the keyframes known to observe the point, with their keypoints.
  std::map<KeyframeId, uint32_t> Observations(MapPointId id) const;

  // Returns what each keyframe sees, one entry a keypoint.
  const std::map<KeyframeId, std::vector<MapPointId>>& keyframes() const { return points_; }

  // Says which of a keyframe's observations are to be told.
  struct Rules {
    // Observations of points for which it is false wait.
    std::function<bool(MapPointId)> can_tell;
    // Where a keypoint sees nothing in place of another local map's point, the point has only been
    // unloaded, and nothing is told, unless this holds for the keypoint.
    std::function<bool(uint32_t)> is_withdrawn;
    // Keypoints for which it is false have no observations that are told.
    std::function<bool(uint32_t)> is_sent = [](uint32_t) { return true; };
    // Once it is false, the rest of the changes waits.
    std::function<bool()> has_room = [] { return true; };
  };
  // Appends the changes that turn the mirrored observations of `keyframe` into those it has now,
  // removals first, and mirrors them. Returns false if some wait, and it is to be called again
  // later.
  bool AppendChanges(const Keyframe& keyframe, const Rules& rules,
                     std::vector<ObservationChange>& changes);

  // Returns for how many pairs of keyframes the changes so far changed the number of points that
  // both see: what they cost the store (map_store/ingest/batch_cost.h).
  uint64_t pairs() const { return pairs_; }

 private:
  void Erase(KeyframeId keyframe, uint32_t keypoint);

  std::map<KeyframeId, std::vector<MapPointId>> points_;
  std::map<MapPointId, std::map<KeyframeId, uint32_t>> observers_;
  uint64_t pairs_ = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_OBSERVATION_MIRROR_H_
