// Tells a robot of keyframes of its own earlier local maps, as a map store tells of others'.
#ifndef CORBSLAM_CLIENT_AGENT_FAR_FAR_SHARE_H_
#define CORBSLAM_CLIENT_AGENT_FAR_FAR_SHARE_H_

#include <map>
#include <span>
#include <vector>

#include "slam/exchange/shared_update.h"
#include "slam/map/map.h"

namespace corbslam::client_agent {

// Keeps account of what the robot's local map in use was told. Not thread-safe.
class FarShare {
 public:
  // Another local map is in use, which was told nothing.
  void Restart();

  // Returns an update that brings the keyframes, of the local map that they are of, with the points
  // that they see. The update's global frame is the robot's own, which is not connected to any
  // mission's.
  SharedUpdate Bring(const Map& local_map, std::span<const KeyframeId> ids);
  // Returns an update that takes them out again, with the points that no other one sees.
  SharedUpdate TakeOut(std::span<const KeyframeId> ids);

  bool HasTold(KeyframeId id) const { return told_.contains(id); }
  // The points that each keyframe sees.
  const std::map<KeyframeId, std::vector<MapPointId>>& told() const { return told_; }

 private:
  // Returns an update that says where the robot's frame lies, if that was not said yet.
  SharedUpdate BeginUpdate();

  uint64_t updates_ = 0;
  bool told_place_ = false;
  std::map<KeyframeId, std::vector<MapPointId>> told_;
  std::map<MapPointId, int> viewers_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_FAR_FAR_SHARE_H_
