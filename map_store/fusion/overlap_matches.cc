#include "map_store/fusion/overlap_matches.h"

#include <algorithm>
#include <limits>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "map_store/view/sights.h"
#include "slam/camera/camera.h"
#include "slam/features/keypoint.h"
#include "slam/matching/word_matching.h"

namespace corbslam::map_store {
namespace {

using KeypointPair = std::pair<uint32_t, uint32_t>;

// As place verification has them (projection_search.h).
constexpr double kRadius_px = 8;
constexpr int kMaxDistance = 50;
constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();

std::vector<KeypointPair> PairByLandmarks(const Sights& query, const Sights& candidate) {
  absl::flat_hash_map<MapPointId, uint32_t> of_candidate;
  for (const auto& [keypoint, point] : candidate) of_candidate.try_emplace(point, keypoint);
  std::vector<KeypointPair> pairs;
  for (const auto& [keypoint, point] : query) {
    const auto it = of_candidate.find(point);
    if (it != of_candidate.end()) pairs.emplace_back(keypoint, it->second);
  }
  return pairs;
}

std::optional<Eigen::Vector3d> InCamera(const OverlapSides& sides, uint32_t keypoint) {
  if (const auto& point = sides.query_points[keypoint]; point.has_value()) {
    return sides.query.camera_from_map * *point;
  }
  const Keypoint& seen = sides.query.keypoints()[keypoint];
  const Camera& camera = sides.query.camera();
  if (!camera.IsMetric() || !seen.HasDepth()) return std::nullopt;
  const double depth = DepthFromDisparity(camera, seen.disparity_px);
  return depth * Eigen::Vector3d((seen.x_px - camera.cx_px) / camera.fx_px,
                                 (seen.y_px - camera.cy_px) / camera.fy_px, 1);
}

// Finds keypoints where the overlap's similarity puts them.
class GuidedSearch {
 public:
  explicit GuidedSearch(const OverlapSides& sides) : sides_(sides) {}

  // Returns the candidate's keypoint that looks most like this one, and the distance; kNone: none
  // does.
  std::pair<uint32_t, int> Find(uint32_t keypoint) {
    std::pair<uint32_t, int> best{kNone, kMaxDistance + 1};
    const auto in_query = InCamera(sides_, keypoint);
    if (!in_query.has_value() || keypoint >= sides_.query.descriptors().size()) return best;
    const Eigen::Vector3d in_candidate = sides_.overlap.candidate_from_query * *in_query;
    if (in_candidate.z() <= 0) return best;
    const Eigen::Vector2d pixel = Project(sides_.candidate.camera(), in_candidate);
    const int octave = sides_.query.keypoints()[keypoint].octave;
    near_.clear();
    sides_.candidate.payload->grid.FindNear(sides_.candidate.keypoints(), pixel.x(), pixel.y(),
                                            kRadius_px * ScalePyramid::Scale(octave), 0,
                                            ScalePyramid::kLevels - 1, near_);
    const Descriptor& wanted = sides_.query.descriptors()[keypoint];
    for (const uint32_t near : near_) {
      if (near >= sides_.candidate.descriptors().size()) continue;
      const int distance = HammingDistance(wanted, sides_.candidate.descriptors()[near]);
      if (distance < best.second) best = {near, distance};
    }
    return best;
  }

 private:
  const OverlapSides& sides_;
  std::vector<uint32_t> near_;
};

// Gives each keypoint of the candidate to the nearest descriptor that wants it.
std::vector<KeypointPair> PairByPlace(const OverlapSides& sides) {
  GuidedSearch search(sides);
  absl::flat_hash_map<uint32_t, std::pair<uint32_t, int>> best;  // By the candidate's keypoint.
  for (uint32_t keypoint = 0; keypoint < sides.query.keypoints().size(); ++keypoint) {
    const auto [found, distance] = search.Find(keypoint);
    if (found == kNone) continue;
    const auto [it, is_new] = best.try_emplace(found, keypoint, distance);
    if (!is_new && distance < it->second.second) it->second = {keypoint, distance};
  }
  std::vector<KeypointPair> pairs;
  for (const auto& [candidate, query] : best) pairs.emplace_back(query.first, candidate);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

// Adds pairs whose keypoints are free, up to the limit.
void AddFree(const std::vector<KeypointPair>& more, std::vector<KeypointPair>& pairs) {
  absl::flat_hash_set<uint32_t> of_query;
  absl::flat_hash_set<uint32_t> of_candidate;
  for (const auto& [query, candidate] : pairs) {
    of_query.insert(query);
    of_candidate.insert(candidate);
  }
  for (const auto& [query, candidate] : more) {
    if (pairs.size() >= kMaxOverlapMatches) return;
    if (of_query.contains(query) || of_candidate.contains(candidate)) continue;
    of_query.insert(query);
    of_candidate.insert(candidate);
    pairs.emplace_back(query, candidate);
  }
}

}  // namespace

std::optional<OverlapSides> TakeOverlapSides(const MissionState& state, const Overlap& overlap) {
  const Keyframe* const query = state.FindKeyframe(overlap.query);
  const Keyframe* const candidate = state.FindKeyframe(overlap.candidate);
  if (query == nullptr || candidate == nullptr) return std::nullopt;
  OverlapSides sides{overlap, *query, *candidate, {}, {}};
  sides.query_points.resize(query->keypoints().size());
  const size_t count = std::min(query->points.size(), sides.query_points.size());
  for (size_t i = 0; i < count; ++i) {
    const MapPointId id = query->points[i];
    // Points of other local maps stand in another frame.
    if (!id.IsValid() || state.OwnerOf(id.local_map) != state.OwnerOf(overlap.query.local_map)) {
      continue;
    }
    if (const MapPoint* const point = state.FindPoint(id)) {
      sides.query_points[i] = point->position_in_map;
    }
  }
  sides.of_landmarks = PairByLandmarks(
      SightsOf(state, *state.FindLocalMap(overlap.query.local_map), *query),
      SightsOf(state, *state.FindLocalMap(overlap.candidate.local_map), *candidate));
  return sides;
}

std::vector<std::pair<uint32_t, uint32_t>> MatchOverlap(const OverlapSides& sides) {
  std::vector<KeypointPair> pairs;
  AddFree(sides.of_landmarks, pairs);
  if (sides.overlap.IsAccepted()) {
    if (sides.query.payload->camera != nullptr && sides.candidate.payload->camera != nullptr) {
      AddFree(PairByPlace(sides), pairs);
    }
  } else if (sides.of_landmarks.empty()) {
    WordMatchingOptions alike;
    alike.need_points_a = alike.need_points_b = false;
    if (sides.query.words != nullptr && sides.candidate.words != nullptr) {
      AddFree(MatchByWords(sides.query, sides.candidate, alike), pairs);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace corbslam::map_store
