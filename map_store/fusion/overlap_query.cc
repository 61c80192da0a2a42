#include "map_store/fusion/overlap_query.h"

#include <algorithm>
#include <set>
#include <utility>

#include "map_store/ingest/local_motion.h"
#include "map_store/view/island_view.h"
#include "map_store/view/landmark_agreement.h"
#include "map_store/view/placement.h"
#include "slam/place/candidate_groups.h"
#include "slam/place/keyframe_database.h"
#include "slam/util/status_macros.h"
#include "slam/verification/place_verification.h"

namespace corbslam::map_store {
namespace {

using Candidate = VerifyOverlapRequest::Candidate;

size_t Gap(const LocalMapState& local_map, KeyframeId a, KeyframeId b) {
  const size_t first = local_map.arrival.at(a);
  const size_t second = local_map.arrival.at(b);
  return first > second ? first - second : second - first;
}

// Returns the keyframes within `spacing` of the query in its local map that were sent under the
// same name; some may have gone.
std::vector<KeyframeId> KeyframesNearby(const LocalMapState& own, KeyframeId query,
                                        size_t spacing) {
  const size_t centre = own.arrival.at(query);
  const size_t begin = centre < spacing ? 0 : centre - spacing + 1;
  std::vector<KeyframeId> nearby;
  for (size_t i = begin; i < std::min(centre + spacing, own.arrived.size()); ++i) {
    if (own.arrived[i].local_map == query.local_map) nearby.push_back(own.arrived[i]);
  }
  return nearby;
}

std::vector<PlaceCandidate> FindSharingWords(const MissionState& state, const QueryTask& task,
                                             const Keyframe& query,
                                             const MapStoreOptions& options) {
  const LocalMapState& against = *state.FindLocalMap(task.against);
  const bool own = state.OwnerOf(task.against) == state.OwnerOf(task.query.local_map);
  QueryOptions query_options;
  query_options.min_shared_words = options.min_shared_words;
  query_options.min_shared_fraction_of_best = options.min_shared_words_ratio;
  query_options.admit = [&](KeyframeId id) {
    if (id == task.query || !against.IsSettled(id)) return false;
    return !own || Gap(against, id, task.query) >= options.min_loop_gap;
  };
  return against.database.Query(query.words->bag, query_options);
}

// Returns whether both see landmarks that say the same as the graph; where these do not, an overlap
// is news.
bool AreLinked(const MissionState& state, KeyframeId query, KeyframeId candidate,
               const MapStoreOptions& options) {
  const std::vector<SharedLandmark> shared = FindSharedLandmarks(state, query, candidate);
  if (shared.empty() || std::cmp_less(shared.size(), options.min_shared_landmarks)) return false;
  return LandmarkDisagreementPx(state, query, candidate, shared) <= options.loop_residual_px;
}

// So many of a local map's first keyframes are held against the end of its robot's one before.
constexpr size_t kFirstKeyframes = 5;

// Returns the local map that the same robot began last before this one; null without.
const LocalMapState* MapBefore(const MissionState& state, const LocalMapState& local_map) {
  for (size_t i = local_map.order; i-- > 0;) {
    const LocalMapState* before = state.FindLocalMap(state.order[i]);
    if (before != nullptr && before->agent == local_map.agent) return before;
  }
  return nullptr;
}

// Returns where the robot was last in `task.against` if the query is one of its first keyframes
// after it: a robot that goes on in a new local map (to bound its memory, or after a pause) most
// often does so where it was. Words alone find that place only among others that look like it.
std::optional<KeyframeId> EndOfMapBefore(const MissionState& state, const QueryTask& task) {
  const LocalMapState& own = *state.FindLocalMap(task.query.local_map);
  if (own.arrival.at(task.query) >= kFirstKeyframes) return std::nullopt;
  const LocalMapState* before = MapBefore(state, own);
  if (before == nullptr || before->id != task.against) return std::nullopt;
  for (size_t i = before->settled; i-- > 0;) {
    const KeyframeId id = before->arrived[i];
    if (before->map.FindKeyframe(id) != nullptr) return id;
  }
  return std::nullopt;
}

bool IsComplete(const VerifyOverlapRequest& request) {
  return request.query_view->FindKeyframe(request.query) != nullptr &&
         std::ranges::all_of(request.candidates, [&request](const auto& candidate) {
           return request.candidate_view.FindKeyframe(candidate.id) != nullptr;
         });
}

// Adds the keyframe and its most covisible ones, until there are so many beside those in `except`:
// a keyframe that a worker leaves out of a neighbourhood because it is in the other one does not
// make that neighbourhood smaller.
void AddWithNeighbours(const MissionState& state, KeyframeId id, int neighbours,
                       const std::set<KeyframeId>& except, std::set<KeyframeId>& keyframes) {
  keyframes.insert(id);
  const Map& map = state.FindLocalMap(id.local_map)->map;
  for (const CovisibleKeyframe& other : map.Covisible(id, 1)) {
    if (neighbours == 0) return;
    keyframes.insert(other.id);
    if (!except.contains(other.id)) --neighbours;
  }
}

FoundPlaces AlreadyLinked() {
  FoundPlaces places;
  places.are_linked = true;
  return places;
}

}  // namespace

absl::StatusOr<std::shared_ptr<const Map>> QueryViews::ViewAround(
    const std::set<KeyframeId>& keyframes, const MissionState& state, LongRead& read) {
  if (view_ != nullptr && version_ == state.version && keyframes_ == keyframes) return view_;
  Clear();
  const uint64_t version = state.version;
  ASSIGN_OR_RETURN(Map view, BuildPartialView(state, keyframes, read));
  auto shared = std::make_shared<const Map>(std::move(view));
  if (version != state.version) return shared;
  version_ = version;
  keyframes_ = keyframes;
  view_ = shared;
  return shared;
}

bool BothMetric(const LocalMapState& a, const LocalMapState& b) {
  const auto is_metric = [](const std::shared_ptr<const Camera>& camera) {
    return camera->IsMetric();
  };
  return std::all_of(a.cameras.begin(), a.cameras.end(), is_metric) &&
         std::all_of(b.cameras.begin(), b.cameras.end(), is_metric);
}

bool HasOverlapNearby(const MissionState& state, const QueryTask& task,
                      const MapStoreOptions& options) {
  const LocalMapState& own = *state.FindLocalMap(task.query.local_map);
  const LocalMapId against = state.OwnerOf(task.against);
  const OverlapLedger& overlaps = state.global.overlaps;
  const auto leads_there = [&](KeyframeId near, uint64_t id) {
    const Overlap& overlap = overlaps.at(id).overlap;
    const KeyframeId far = overlap.query == near ? overlap.candidate : overlap.query;
    return state.OwnerOf(far.local_map) == against;
  };
  return std::ranges::any_of(
      KeyframesNearby(own, task.query, options.overlap_spacing), [&](KeyframeId near) {
        return std::ranges::any_of(overlaps.LiveAt(near),
                                   [&](uint64_t id) { return leads_there(near, id); });
      });
}

Resemblance FindResemblance(const MissionState& state, const QueryTask& task,
                            const MapStoreOptions& options) {
  const Keyframe* query = state.FindKeyframe(task.query);
  if (query == nullptr || query->words == nullptr) return {};
  if (state.FindLocalMap(task.against) == nullptr) return {};
  const std::vector<PlaceCandidate> found = FindSharingWords(state, task, *query, options);
  return {found.empty() ? 0 : found.front().score, EndOfMapBefore(state, task).has_value()};
}

FoundPlaces FindCandidates(const MissionState& state, const QueryTask& task,
                           const MapStoreOptions& options) {
  const Keyframe* query = state.FindKeyframe(task.query);
  const LocalMapState* against = state.FindLocalMap(task.against);
  if (query == nullptr || query->words == nullptr || against == nullptr) return {};
  if (HasOverlapNearby(state, task, options)) return AlreadyLinked();
  const std::vector<PlaceCandidate> found = FindSharingWords(state, task, *query, options);
  FoundPlaces places;
  std::vector<Candidate>& candidates = places.candidates;
  if (!found.empty()) places.likeness = found.front().score;
  for (const CandidateGroup& group :
       GroupByCovisibility(against->map, found, options.max_candidate_groups)) {
    const KeyframeId best = group.best.id;
    if (AreLinked(state, task.query, best, options)) {
      // The best of all is linked already, so that there is no news to be had here.
      if (candidates.empty()) return AlreadyLinked();
      continue;
    }
    candidates.push_back({best, group.best.shared_words});
  }
  const std::optional<KeyframeId> end = EndOfMapBefore(state, task);
  if (end.has_value() && std::ranges::find(candidates, *end, &Candidate::id) == candidates.end() &&
      !AreLinked(state, task.query, *end, options)) {
    const auto words = std::ranges::find(found, *end, &PlaceCandidate::id);
    candidates.insert(candidates.begin(), {*end, words == found.end() ? 0 : words->shared_words});
  }
  places.is_seam = end.has_value() && !candidates.empty();
  return places;
}

absl::StatusOr<std::optional<VerifyOverlapRequest>> BuildVerifyRequest(
    const MissionState& state, const QueryTask& task, const MapStoreOptions& options,
    LongRead& read, QueryViews& views) {
  VerifyOverlapRequest request;
  request.candidates = FindCandidates(state, task, options).candidates;
  if (request.candidates.empty()) return std::nullopt;
  request.base_revision = state.global.revision;
  request.mission = state.name;
  request.query = task.query;
  request.fix_scale =
      BothMetric(*state.FindLocalMap(task.query.local_map), *state.FindLocalMap(task.against));
  // The neighbourhood has no more keyframes than verification looks at: each one is a hundred
  // kilobytes to make, send and read.
  const int neighbours = PlaceVerificationOptions().neighbours;
  std::set<KeyframeId> candidates;
  for (const VerifyOverlapRequest::Candidate& candidate : request.candidates) {
    candidates.insert(candidate.id);
  }
  std::set<KeyframeId> around_query;
  AddWithNeighbours(state, task.query, neighbours, candidates, around_query);
  std::set<KeyframeId> around_candidates;
  for (const KeyframeId& candidate : candidates) {
    AddWithNeighbours(state, candidate, neighbours, around_query, around_candidates);
  }
  RETURN_IF_ERROR(read.Pause());
  ASSIGN_OR_RETURN(request.query_view, views.ViewAround(around_query, state, read));
  RETURN_IF_ERROR(read.Pause());
  ASSIGN_OR_RETURN(request.candidate_view, BuildPartialView(state, around_candidates, read));
  if (!IsComplete(request)) return absl::AbortedError("a keyframe has gone");
  return request;
}

double GraphResidualPx(const MissionState& state, const Overlap& overlap) {
  const LocalMapState& query_map = *state.FindLocalMap(overlap.query.local_map);
  const LocalMapState& candidate_map = *state.FindLocalMap(overlap.candidate.local_map);
  const Keyframe* query = query_map.map.FindKeyframe(overlap.query);
  const Keyframe* candidate = candidate_map.map.FindKeyframe(overlap.candidate);
  if (query == nullptr || candidate == nullptr) return 0;
  const Similarity3d expected = FindPoses(state, candidate_map)->poses.at(overlap.candidate) *
                                FindPoses(state, query_map)->poses.at(overlap.query).Inverse();
  const Similarity3d difference = overlap.candidate_from_query * expected.Inverse();
  return PixelMotion(difference.ToRigid(), MedianDepth(candidate_map, *candidate),
                     candidate->camera().fx_px);
}

}  // namespace corbslam::map_store
