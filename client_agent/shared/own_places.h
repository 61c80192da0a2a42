// Remembers where fusion has placed the robot's own keyframes.
#ifndef CORBSLAM_CLIENT_AGENT_SHARED_OWN_PLACES_H_
#define CORBSLAM_CLIENT_AGENT_SHARED_OWN_PLACES_H_

#include <map>
#include <vector>

#include "client_agent/map/own_correction.h"
#include "slam/exchange/shared_update.h"
#include "slam/geometry/rigid3.h"
#include "slam/map/map.h"
#include "slam/util/ids.h"

namespace corbslam::client_agent {

// The own places. Each comes with the local pose from which fusion derived it. That one, not the
// keyframe's pose now, says where the global frame lies: what the robot adjusts must not move what
// it is adjusted to. Not thread-safe.
class OwnPlaces {
 public:
  struct Place {
    Rigid3d camera_from_global;
    Rigid3d camera_from_local;
    double local_per_global = 1;  // Units of the local map: of one without metres others than 1.
    Rigid3d LocalFromGlobal() const { return camera_from_local.Inverse() * camera_from_global; }
    Similarity3d GlobalFromLocal() const;
  };

  // Takes in a place from the store, which may not know the robot's last corrections yet: the told
  // local pose is moved by the corrections that it does not contain.
  void Tell(const OwnKeyframePose& told);
  // Forgets all places, because the store will tell all of them again.
  void ForgetAll() { places_.clear(); }
  // Forgets the keyframes that `map` no longer has.
  void ForgetGone(const Map& map);
  void Correct(const OwnCorrection& correction);

  const std::map<KeyframeId, Place>& places() const { return places_; }

 private:
  // Corrections of one keyframe that the store is not known to have taken in.
  using Motions = std::vector<OwnCorrection::Motion>;
  static void Remember(const OwnCorrection::Motion& motion, Motions& motions);

  std::map<KeyframeId, Place> places_;
  std::map<KeyframeId, Motions> motions_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SHARED_OWN_PLACES_H_
