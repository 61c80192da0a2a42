// The part of an island that a pass over its closed local maps looks at.
#ifndef CORBSLAM_MAP_STORE_RETIRING_RETIRING_VIEW_H_
#define CORBSLAM_MAP_STORE_RETIRING_RETIRING_VIEW_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/statusor.h"
#include "map_store/state/mission_state.h"
#include "map_store/view/long_read.h"
#include "slam/map/map.h"

namespace corbslam::map_store {

// A value that shares nothing but the payloads with the state that it was made of.
struct RetiringView {
  IslandId island;
  uint64_t revision = 0;
  // The keyframes around some that the caller named, and what they see, in the island's frame;
  // camera units are rescaled to the island's.
  Map map{Covisibility::kGiven};
  // The keyframes' poses with their own scales.
  IslandPoses poses;
  // The keyframes' parents in their local maps, and the local poses of both.
  std::map<KeyframeId, KeyframeId> parents;
  std::map<KeyframeId, Rigid3d> local_poses;
  // Keyframes of closed local maps of whose landmarks the view has all sights: these may go.
  std::set<KeyframeId> candidates;
  // The points that are one landmark, by its survivor, of all that candidates see.
  absl::flat_hash_map<MapPointId, std::vector<MapPointId>> landmarks;
  // The closed local maps of the island: the local map that each has become a part of, or itself,
  // their place in the order of arrival, their last batch, and how many keyframes are left of each.
  struct Closed {
    LocalMapId whole;
    size_t order = 0;
    uint64_t last_batch = 0;
    size_t keyframes = 0;
  };
  std::map<LocalMapId, Closed> closed;
  // Overlaps in the graph whose keyframes live, in two local maps of the island.
  std::vector<std::pair<KeyframeId, KeyframeId>> overlaps;
};

struct RetiringReach {
  // Landmarks that a keyframe shares with one that the caller named to be a candidate itself.
  int min_shared = 15;
  // Candidates at most; those that share most come first.
  size_t max_candidates = 200;
};

// Takes the view around `named` keyframes, which are of one island's closed local maps; unknown
// ones are skipped. Costs as much as is seen around them. Returns ABORTED as `read` does.
absl::StatusOr<RetiringView> TakeRetiringView(const MissionState& state, const Island& island,
                                              const std::set<KeyframeId>& named,
                                              const RetiringReach& reach, LongRead& read);

// Returns the keyframes that see the landmark (or point) by any of its names, as owners say, each
// once.
std::vector<KeyframeId> ViewersOf(const MissionState& state, MapPointId landmark);

// Returns whether the view is of the state as far as it matters to what goes: no fusion came
// between, nor a batch of a closed local map, nor does anybody else see a point of `faded` now.
bool IsStillTrue(const RetiringView& view, const std::vector<MapPointId>& faded,
                 const MissionState& state);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RETIRING_RETIRING_VIEW_H_
