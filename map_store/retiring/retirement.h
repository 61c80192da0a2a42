// What the store itself lets go of: keyframes that others stand in for and points that have
// vanished, of local maps that their owners have closed (docs/adr/0033-what-stays-of-a-session.md).
#ifndef CORBSLAM_MAP_STORE_RETIRING_RETIREMENT_H_
#define CORBSLAM_MAP_STORE_RETIRING_RETIREMENT_H_

#include <vector>

#include "absl/status/status.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

struct RetiredKeyframe {
  KeyframeId id;
  // What its owner would have said of it: the nearest ancestor that stays, or a neighbour of its
  // own local map where none does, and its pose of the keyframe in the local layer.
  KeyframeId parent;
  Rigid3d parent_from_removed;
  // What stands in for it in the global layer, which stays as well.
  StandIn stand_in;
};

// Is a value, and what the journal keeps.
struct Retirement {
  std::vector<RetiredKeyframe> keyframes;
  // Points that later keyframes should have seen and did not; all members of a landmark are named.
  std::vector<MapPointId> faded;

  bool empty() const { return keyframes.empty() && faded.empty(); }
};

// Returns DATA_LOSS where the retirement names what the state does not have, what is not closed, or
// what goes with it as what stays.
absl::Status CheckRetirement(const Retirement& retirement, const MissionState& state);

// Applies a retirement that passed the check. Points that no keyframe of their own local map sees
// any more go with the keyframes; where they were part of a landmark, the rest of it is their heir.
// Places stay as they are: points are anchored in other keyframes that see them.
void ApplyRetirement(const Retirement& retirement, MissionState& state);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RETIRING_RETIREMENT_H_
