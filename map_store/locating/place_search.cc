#include "map_store/locating/place_search.h"

#include <algorithm>
#include <set>
#include <utility>

#include "map_store/view/island_view.h"
#include "map_store/view/placement.h"
#include "slam/place/candidate_groups.h"
#include "slam/place/keyframe_database.h"
#include "slam/util/status_macros.h"
#include "slam/verification/frame_location.h"

namespace corbslam::map_store {
namespace {

constexpr double kReach = 1.5;  // Of a prior's radius.
// A place that shares fewer words than this share of the best one's is none.
constexpr double kMinSharedOfBest = 0.4;

struct Place {
  IslandId island;
  CandidateGroup group;
};

bool IsNear(const PosePrior& prior, const IslandPoses& poses, KeyframeId id) {
  const auto pose = poses.find(id);
  if (pose == poses.end()) return false;
  const Eigen::Vector3d centre = pose->second.Inverse().translation;
  const Eigen::Vector3d expected = prior.camera_from_global.Inverse().translation;
  return (centre - expected).norm() <= kReach * prior.radius_m;
}

void AddPlaces(const MissionState& state, const LocalMapState& local_map, const BagOfWords& bag,
               const PlaceSearch& search, const MapStoreOptions& options,
               std::vector<Place>& places) {
  const std::shared_ptr<const PoseTable> poses =
      search.prior.has_value() ? FindPoses(state, local_map) : nullptr;
  QueryOptions query;
  query.min_shared_words = options.min_shared_words;
  query.min_shared_fraction_of_best = options.min_shared_words_ratio;
  query.admit = [&](KeyframeId id) {
    if (state.global.culled.contains(id)) return false;
    return poses == nullptr || IsNear(*search.prior, poses->poses, id);
  };
  const std::vector<PlaceCandidate> found = local_map.database.Query(bag, query);
  const IslandId island = state.FindIslandOf(local_map.id)->id;
  // One local map may be the whole mission: it may give all places.
  for (CandidateGroup& group : GroupByCovisibility(local_map.map, found, search.max_places)) {
    places.push_back({island, std::move(group)});
  }
}

// Keeps the best places, best first.
void KeepBest(size_t max_places, std::vector<Place>& places) {
  std::stable_sort(places.begin(), places.end(),
                   [](const Place& a, const Place& b) { return a.group.score > b.group.score; });
  int most_words = 0;
  for (const Place& place : places)
    most_words = std::max(most_words, place.group.best.shared_words);
  std::erase_if(places, [most_words](const Place& place) {
    return place.group.best.shared_words < kMinSharedOfBest * most_words;
  });
  if (places.size() > max_places) places.resize(max_places);
}

}  // namespace

absl::StatusOr<std::vector<PlacesOfIsland>> FindPlaces(const MissionState& state,
                                                       const BagOfWords& bag,
                                                       const PlaceSearch& search,
                                                       const MapStoreOptions& options,
                                                       LongRead& read) {
  const bool only_reference = search.prior.has_value() || !search.all_islands;
  std::vector<Place> places;
  // Local maps may be added during a pause.
  for (size_t i = 0; i < state.order.size(); ++i) {
    const LocalMapId id = state.order[i];
    if (only_reference && state.FindIslandOf(id)->id != state.ReferenceIsland()) continue;
    AddPlaces(state, *state.FindLocalMap(id), bag, search, options, places);
    RETURN_IF_ERROR(read.Pause());
  }
  KeepBest(search.max_places, places);
  std::vector<PlacesOfIsland> islands;
  for (const Place& place : places) {
    auto of_island = std::ranges::find(islands, place.island, &PlacesOfIsland::island);
    if (of_island == islands.end()) of_island = islands.insert(islands.end(), {place.island, {}});
    of_island->candidates.push_back({place.group.best.id, place.group.best.shared_words});
  }
  return islands;
}

absl::StatusOr<LocateFrameRequest> BuildLocateRequest(
    const MissionState& state, const std::vector<LocateFrameRequest::Candidate>& candidates,
    LongRead& read) {
  const size_t neighbours = static_cast<size_t>(FrameLocationOptions().neighbours);
  LocateFrameRequest request;
  request.base_revision = state.global.revision;
  std::set<KeyframeId> keyframes;
  for (const LocateFrameRequest::Candidate& candidate : candidates) {
    const LocalMapState* local_map = state.FindLocalMap(candidate.id.local_map);
    if (local_map == nullptr || local_map->map.FindKeyframe(candidate.id) == nullptr) continue;
    keyframes.insert(candidate.id);
    size_t added = 0;
    for (const CovisibleKeyframe& other : local_map->map.Covisible(candidate.id, 1)) {
      if (added++ == neighbours) break;
      keyframes.insert(other.id);
    }
  }
  ASSIGN_OR_RETURN(request.view, BuildPartialView(state, keyframes, read));
  for (const LocateFrameRequest::Candidate& candidate : candidates) {
    if (request.view.FindKeyframe(candidate.id) != nullptr) request.candidates.push_back(candidate);
  }
  return request;
}

}  // namespace corbslam::map_store
