// Finds where in a mission's map a picture may have been taken, by its words.
#ifndef CORBSLAM_MAP_STORE_LOCATING_PLACE_SEARCH_H_
#define CORBSLAM_MAP_STORE_LOCATING_PLACE_SEARCH_H_

#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "map_store/locating/localize_query.h"
#include "map_store/options/options.h"
#include "map_store/state/mission_state.h"
#include "map_store/view/long_read.h"
#include "slam/vocabulary/words.h"

namespace corbslam::map_store {

// Places of one island.
struct PlacesOfIsland {
  IslandId island;
  std::vector<LocateFrameRequest::Candidate> candidates;  // Best first.
};

struct PlaceSearch {
  std::optional<PosePrior> prior;
  bool all_islands = false;
  size_t max_places = 12;  // Of all islands together.
};

// Returns keyframes that share words with the picture, the best of each group of covisible ones, by
// island: first that of the best one. With a prior, keyframes count that stand within its radius of
// it and half as much again: what is seen from a place is seen from beside it too. Keyframes that
// fusion does without don't count. ABORTED as `read` says, which pauses after each local map.
absl::StatusOr<std::vector<PlacesOfIsland>> FindPlaces(const MissionState& state,
                                                       const BagOfWords& bag,
                                                       const PlaceSearch& search,
                                                       const MapStoreOptions& options,
                                                       LongRead& read);

// Returns the candidates with what is covisible with them, in their island's frame; without those
// whose owner removed them meanwhile. ABORTED as `read` says. The caller adds the picture.
absl::StatusOr<LocateFrameRequest> BuildLocateRequest(
    const MissionState& state, const std::vector<LocateFrameRequest::Candidate>& candidates,
    LongRead& read);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_LOCATING_PLACE_SEARCH_H_
