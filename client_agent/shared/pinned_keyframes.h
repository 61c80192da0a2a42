// Finds which of others' keyframes the robot's own sight pins to where they are in its map.
#ifndef CORBSLAM_CLIENT_AGENT_SHARED_PINNED_KEYFRAMES_H_
#define CORBSLAM_CLIENT_AGENT_SHARED_PINNED_KEYFRAMES_H_

#include <map>

#include "slam/geometry/rigid3.h"
#include "slam/map/map.h"
#include "slam/util/ids.h"

namespace corbslam::client_agent {

// The foreign keyframes that are pinned. A foreign keyframe is pinned by the own one that shares
// the most points with it, if both see most of these where they stand in the map. Not thread-safe.
class PinnedKeyframes {
 public:
  explicit PinnedKeyframes(LocalMapId own) : own_(own) {}

  // Looks at every foreign keyframe of `map`. Its points are looked at only where either of the two
  // keyframes has moved since the last time, or the number of points that they share has changed.
  void Update(const Map& map);

  bool Contains(KeyframeId id) const { return PinOf(id).IsValid(); }
  // Returns the own keyframe that pins it, as of the last Update; invalid where none does.
  KeyframeId PinOf(KeyframeId id) const;

 private:
  // Remembers how a foreign keyframe and the own one that shares the most with it stood last.
  struct Contact {
    KeyframeId own;
    int shared = 0;
    Rigid3d foreign_from_map;
    Rigid3d own_from_map;
    bool agrees = false;
  };
  static bool IsAsBefore(const Contact& before, const Contact& now);

  const LocalMapId own_;
  std::map<KeyframeId, Contact> contacts_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SHARED_PINNED_KEYFRAMES_H_
