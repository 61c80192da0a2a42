#include "slam/verification/place_verification.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "slam/matching/word_matching.h"
#include "slam/optimisation/similarity_refinement.h"
#include "slam/solvers/pnp_ransac.h"
#include "slam/solvers/similarity_ransac.h"
#include "slam/verification/neighbourhood.h"
#include "slam/verification/projection_search.h"

namespace corbslam {
namespace {

// Variance of a pixel that is computed because the keyframe itself does not see the point.
constexpr double kVirtualVariance_px2 = 4;
// With so many samples a fifth of right matches is found in 99 of 100 cases.
constexpr int kRansacIterations = 600;
constexpr double kFirstRadius_px = 10;
constexpr double kLastRadius_px = 5;

// The query's or the candidate's side of the comparison.
struct Side {
  const Map& map;
  const Keyframe& centre;
  std::vector<const Keyframe*> keyframes;  // The centre comes first.
  std::vector<const MapPoint*> points;     // Points that these keyframes see.
};

// A pair of points that may be one, and how many pairs of keypoints say so.
struct Votes {
  int count = 0;
  int distance = 257;
};

void VoteByWords(const Keyframe& query, const Keyframe& candidate,
                 std::map<PointPair, Votes>& votes) {
  for (const auto& [i, j] : MatchByWords(query, candidate)) {
    const PointPair pair{query.points[i], candidate.points[j]};
    if (pair.query == pair.candidate) continue;
    Votes& vote = votes[pair];
    ++vote.count;
    vote.distance = std::min(vote.distance,
                             HammingDistance(query.descriptors()[i], candidate.descriptors()[j]));
  }
}

// Elects each point of either side at most once: most votes first, then the nearest, then by id.
std::vector<PointPair> ElectPairs(const std::map<PointPair, Votes>& votes) {
  std::vector<std::pair<PointPair, Votes>> ranked(votes.begin(), votes.end());
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) {
    return std::tuple(-a.second.count, a.second.distance) <
           std::tuple(-b.second.count, b.second.distance);
  });
  absl::btree_set<MapPointId> taken_query;
  absl::btree_set<MapPointId> taken_candidate;
  std::vector<PointPair> pairs;
  for (const auto& [pair, vote] : ranked) {
    if (taken_query.contains(pair.query) || taken_candidate.contains(pair.candidate)) continue;
    taken_query.insert(pair.query);
    taken_candidate.insert(pair.candidate);
    pairs.push_back(pair);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

std::vector<PointPair> MatchNeighbourhoods(const Side& query, const Side& candidate) {
  std::map<PointPair, Votes> votes;
  for (const Keyframe* keyframe : candidate.keyframes) VoteByWords(query.centre, *keyframe, votes);
  for (const Keyframe* keyframe : query.keyframes) {
    if (keyframe != &query.centre) VoteByWords(*keyframe, candidate.centre, votes);
  }
  return ElectPairs(votes);
}

struct View {
  Eigen::Vector3d x_in_camera;
  Eigen::Vector2d pixel;
  double disparity_px = 0;
  double variance_px2 = kVirtualVariance_px2;
  bool is_seen = false;
};

// Returns how the side's central keyframe sees a point: its keypoint, else where it would be.
std::optional<View> ViewOf(const Side& side, MapPointId id) {
  const MapPoint* point = side.map.FindPoint(id);
  if (point == nullptr) return std::nullopt;
  View view;
  view.x_in_camera = side.centre.camera_from_map * point->position_in_map;
  if (view.x_in_camera.z() <= 0) return std::nullopt;
  const auto seen = point->observations.find(side.centre.id());
  if (seen == point->observations.end()) {
    view.pixel = Project(side.centre.camera(), view.x_in_camera);
    return view;
  }
  const Keypoint& keypoint = side.centre.keypoints()[seen->second];
  view.pixel = keypoint.Pixel();
  view.disparity_px = static_cast<double>(keypoint.disparity_px);
  view.variance_px2 = ScalePyramid::Variance_px2(keypoint.octave);
  view.is_seen = true;
  return view;
}

// Drops the pairs that either camera cannot see from `pairs`.
std::vector<SimilarityMatch> MakeMatches(const Side& query, const Side& candidate,
                                         std::vector<PointPair>& pairs) {
  std::vector<SimilarityMatch> matches;
  std::vector<PointPair> kept;
  for (const PointPair& pair : pairs) {
    const auto a = ViewOf(query, pair.query);
    const auto b = ViewOf(candidate, pair.candidate);
    if (!a.has_value() || !b.has_value()) continue;
    matches.push_back(
        {a->x_in_camera, b->x_in_camera, a->pixel, b->pixel, a->variance_px2, b->variance_px2});
    kept.push_back(pair);
  }
  pairs = std::move(kept);
  return matches;
}

// Adds how the neighbours of one side see that side's points of the pairs.
void AddSights(const Side& side, bool is_of_b, const std::vector<PointPair>& pairs,
               std::vector<SimilaritySight>& sights) {
  for (const Keyframe* keyframe : side.keyframes) {
    if (keyframe == &side.centre) continue;
    const Rigid3d camera_from_side =
        keyframe->camera_from_map * side.centre.camera_from_map.Inverse();
    for (size_t i = 0; i < pairs.size(); ++i) {
      const MapPoint* point = side.map.FindPoint(is_of_b ? pairs[i].candidate : pairs[i].query);
      if (point == nullptr) continue;
      const auto seen = point->observations.find(keyframe->id());
      if (seen == point->observations.end()) continue;
      const Keypoint& keypoint = keyframe->keypoints()[seen->second];
      sights.push_back({.match = i,
                        .is_of_b = is_of_b,
                        .camera = &keyframe->camera(),
                        .camera_from_side = camera_from_side,
                        .pixel = keypoint.Pixel(),
                        .variance_px2 = ScalePyramid::Variance_px2(keypoint.octave)});
    }
  }
}

// Returns the neighbours' sights of what both sides have matched, where these are to say a scale.
std::vector<SimilaritySight> SightsBeside(const Side& query, const Side& candidate,
                                          const std::vector<PointPair>& pairs, bool fix_scale) {
  std::vector<SimilaritySight> sights;
  if (fix_scale) return sights;
  AddSights(query, /*is_of_b=*/false, pairs, sights);
  AddSights(candidate, /*is_of_b=*/true, pairs, sights);
  return sights;
}

// Estimates the query's pose against the candidate's points alone, where depths are too poor for an
// alignment of points.
std::optional<Similarity3d> EstimateByPose(const Side& query, const Side& candidate,
                                           const std::vector<PointPair>& pairs,
                                           const PlaceVerificationOptions& options, int& inliers) {
  std::vector<PoseObservation> observations;
  for (const PointPair& pair : pairs) {
    const auto seen = ViewOf(query, pair.query);
    const MapPoint* point = candidate.map.FindPoint(pair.candidate);
    if (!seen.has_value() || !seen->is_seen || point == nullptr) continue;
    observations.push_back(
        {point->position_in_map, seen->pixel, seen->disparity_px, seen->variance_px2});
  }
  if (observations.size() < static_cast<size_t>(options.min_ransac_inliers)) return std::nullopt;
  const PnpRansacOptions pnp{.min_inliers = options.min_ransac_inliers, .seed = options.seed};
  const auto pose = EstimatePose(query.centre.camera(), observations, pnp);
  if (!pose.ok()) return std::nullopt;
  inliers = pose->inliers;
  return Similarity3d::FromRigid(candidate.centre.camera_from_map *
                                 pose->camera_from_map.Inverse());
}

// Sets the number of inliers even where it finds nothing.
std::optional<Similarity3d> EstimateByRansac(const Side& query, const Side& candidate,
                                             std::vector<PointPair> pairs,
                                             const PlaceVerificationOptions& options,
                                             int& inliers) {
  const std::vector<SimilarityMatch> matches = MakeMatches(query, candidate, pairs);
  if (matches.size() < 3) return std::nullopt;
  SimilarityRansacOptions ransac;
  ransac.fix_scale = options.fix_scale;
  ransac.min_inliers = 3;  // The count is judged here, so that it can be told whatever it is.
  ransac.max_chi2 = kMaxChi2OfSimilarity;
  ransac.seed = options.seed;
  ransac.max_iterations = kRansacIterations;
  const auto similarity =
      EstimateSimilarity(query.centre.camera(), candidate.centre.camera(), matches, ransac);
  if (similarity.ok()) inliers = similarity->inliers;
  if (inliers >= options.min_ransac_inliers) return similarity->b_from_a;
  if (!options.fix_scale) return std::nullopt;
  return EstimateByPose(query, candidate, pairs, options, inliers);
}

Rigid3d QueryCameraFromCandidateMap(const Similarity3d& candidate_from_query, const Keyframe& query,
                                    const Keyframe& candidate, const Keyframe& other_query) {
  const Similarity3d other_from_query =
      Similarity3d::FromRigid(other_query.camera_from_map * query.camera_from_map.Inverse());
  return (other_from_query * candidate_from_query.Inverse() *
          Similarity3d::FromRigid(candidate.camera_from_map))
      .ToRigid();
}

Rigid3d CandidateCameraFromQueryMap(const Similarity3d& candidate_from_query, const Keyframe& query,
                                    const Keyframe& candidate, const Keyframe& other_candidate) {
  return QueryCameraFromCandidateMap(candidate_from_query.Inverse(), candidate, query,
                                     other_candidate);
}

// Finds pairs of points that project onto each other, looked for both ways.
std::vector<PointPair> SearchBothWays(const Side& query, const Side& candidate,
                                      const Similarity3d& candidate_from_query, double radius_px,
                                      bool check_disparity) {
  const ProjectionSearchOptions search{.radius_px = radius_px,
                                       .only_keypoints_with_points = true,
                                       .check_disparity = check_disparity};
  std::map<PointPair, Votes> votes;
  const auto vote = [&votes](const PointPair& pair, int distance) {
    if (pair.query == pair.candidate) return;
    Votes& entry = votes[pair];
    ++entry.count;
    entry.distance = std::min(entry.distance, distance);
  };
  const Rigid3d query_from_candidate_map = QueryCameraFromCandidateMap(
      candidate_from_query, query.centre, candidate.centre, query.centre);
  for (const ProjectionMatch& match :
       FindByProjection(candidate.points, query.centre, query_from_candidate_map, search)) {
    vote({query.centre.points[match.keypoint], candidate.points[match.point]->id}, match.distance);
  }
  const Rigid3d candidate_from_query_map = CandidateCameraFromQueryMap(
      candidate_from_query, query.centre, candidate.centre, candidate.centre);
  for (const ProjectionMatch& match :
       FindByProjection(query.points, candidate.centre, candidate_from_query_map, search)) {
    vote({query.points[match.point]->id, candidate.centre.points[match.keypoint]}, match.distance);
  }
  return ElectPairs(votes);
}

// Searches, guided, in a shrinking radius, and refines each time on all that was found.
bool Refine(const Side& query, const Side& candidate, const PlaceVerificationOptions& options,
            Overlap& overlap) {
  for (const double radius_px : {kFirstRadius_px, kLastRadius_px}) {
    std::vector<PointPair> pairs = SearchBothWays(query, candidate, overlap.candidate_from_query,
                                                  radius_px, options.fix_scale);
    const std::vector<SimilarityMatch> matches = MakeMatches(query, candidate, pairs);
    overlap.evidence.guided_matches = static_cast<int>(matches.size());
    overlap.evidence.refined_inliers = 0;
    if (matches.size() < 3) return false;
    const auto refined =
        RefineSimilarity(query.centre.camera(), candidate.centre.camera(), matches,
                         overlap.candidate_from_query, options.fix_scale, kMaxChi2OfSimilarity,
                         SightsBeside(query, candidate, pairs, options.fix_scale));
    if (!refined.ok()) return false;
    overlap.candidate_from_query = refined->b_from_a;
    overlap.evidence.refined_inliers = refined->inliers;
    overlap.inliers.clear();
    for (size_t i = 0; i < pairs.size(); ++i) {
      if (refined->is_inlier[i]) overlap.inliers.push_back(pairs[i]);
    }
  }
  return overlap.evidence.refined_inliers >= options.min_refined_inliers;
}

bool HasRightScale(const Side& query, const Side& candidate,
                   const PlaceVerificationOptions& options, double scale) {
  if (options.fix_scale) return true;
  if (!query.centre.camera().IsMetric() || !candidate.centre.camera().IsMetric()) return true;
  return std::abs(scale - 1) <= options.max_scale_deviation;
}

int CountProjected(const std::vector<const MapPoint*>& points, const Keyframe& keyframe,
                   const Rigid3d& camera_from_points, const PlaceVerificationOptions& options) {
  const ProjectionSearchOptions search{.radius_px = kLastRadius_px,
                                       .check_disparity = options.fix_scale};
  return static_cast<int>(FindByProjection(points, keyframe, camera_from_points, search).size());
}

// Counts neighbours of either side that find the other side's points where they should be.
int CountConsistentKeyframes(const Side& query, const Side& candidate,
                             const PlaceVerificationOptions& options,
                             const Similarity3d& candidate_from_query) {
  int consistent = 0;
  for (const Keyframe* other : query.keyframes) {
    if (other == &query.centre) continue;
    const Rigid3d camera_from_points =
        QueryCameraFromCandidateMap(candidate_from_query, query.centre, candidate.centre, *other);
    const int found = CountProjected(candidate.points, *other, camera_from_points, options);
    if (found >= options.min_matches_per_keyframe) ++consistent;
  }
  for (const Keyframe* other : candidate.keyframes) {
    if (other == &candidate.centre) continue;
    const Rigid3d camera_from_points =
        CandidateCameraFromQueryMap(candidate_from_query, query.centre, candidate.centre, *other);
    const int found = CountProjected(query.points, *other, camera_from_points, options);
    if (found >= options.min_matches_per_keyframe) ++consistent;
  }
  return consistent;
}

// Returns whether the points found are more than another place that looks alike would have.
bool IsMoreThanAlike(const OverlapEvidence& evidence, const PlaceVerificationOptions& options) {
  const bool few =
      evidence.projected_matches < options.min_projected_share * evidence.visible_points;
  const double to_chance =
      few ? options.min_projected_to_chance_of_few : options.min_projected_to_chance;
  return evidence.projected_matches >= to_chance * evidence.chance_matches;
}

// Returns false where the inliers leave a direction open.
bool SetCovariance(const Side& query, const Side& candidate,
                   const PlaceVerificationOptions& options, Overlap& overlap) {
  std::vector<PointPair> pairs = overlap.inliers;
  const std::vector<SimilarityMatch> matches = MakeMatches(query, candidate, pairs);
  const SimilarityRefinement refined{overlap.candidate_from_query,
                                     std::vector<char>(matches.size(), 1),
                                     static_cast<int>(matches.size())};
  const auto covariance = SimilarityCovariance(
      query.centre.camera(), candidate.centre.camera(), matches, refined, options.fix_scale,
      SightsBeside(query, candidate, pairs, options.fix_scale));
  if (covariance.ok()) overlap.covariance = *covariance;
  return covariance.ok();
}

OverlapVerdict Judge(const Side& query, const Side& candidate,
                     const PlaceVerificationOptions& options, Overlap& overlap) {
  OverlapEvidence& evidence = overlap.evidence;
  const std::vector<PointPair> pairs = MatchNeighbourhoods(query, candidate);
  evidence.word_matches = static_cast<int>(pairs.size());
  if (evidence.word_matches < options.min_word_matches) return OverlapVerdict::kTooFewWordMatches;

  const auto estimate = EstimateByRansac(query, candidate, pairs, options, evidence.ransac_inliers);
  if (!estimate.has_value()) return OverlapVerdict::kTooFewRansacInliers;
  overlap.candidate_from_query = *estimate;

  if (!Refine(query, candidate, options, overlap)) return OverlapVerdict::kTooFewRefinedInliers;
  if (!HasRightScale(query, candidate, options, overlap.candidate_from_query.scale)) {
    return OverlapVerdict::kWrongScale;
  }

  const Rigid3d query_from_candidate_map = QueryCameraFromCandidateMap(
      overlap.candidate_from_query, query.centre, candidate.centre, query.centre);
  evidence.projected_matches =
      CountProjected(candidate.points, query.centre, query_from_candidate_map, options);
  evidence.chance_matches = static_cast<int>(
      CountByChance(candidate.points, query.centre, query_from_candidate_map,
                    {.radius_px = kLastRadius_px, .check_disparity = options.fix_scale}));
  evidence.visible_points =
      static_cast<int>(CountVisible(candidate.points, query.centre, query_from_candidate_map));
  if (evidence.projected_matches < options.min_projected_matches ||
      !IsMoreThanAlike(evidence, options)) {
    return OverlapVerdict::kTooFewProjectedMatches;
  }

  evidence.consistent_keyframes =
      CountConsistentKeyframes(query, candidate, options, overlap.candidate_from_query);
  if (evidence.consistent_keyframes < options.min_consistent_keyframes) {
    return OverlapVerdict::kNoSecondKeyframe;
  }
  if (!SetCovariance(query, candidate, options, overlap)) {
    return OverlapVerdict::kTooFewRefinedInliers;
  }
  if (std::sqrt(overlap.covariance(6, 6)) > options.max_log_scale_sigma) {
    return OverlapVerdict::kWrongScale;
  }
  return OverlapVerdict::kAccepted;
}

}  // namespace

Overlap VerifyPlace(const Map& query_view, KeyframeId query, const Map& candidate_view,
                    KeyframeId candidate, const PlaceVerificationOptions& options) {
  Overlap overlap;
  overlap.query = query;
  overlap.candidate = candidate;
  const auto query_keyframes = Neighbourhood(query_view, query, options.neighbours, {candidate});
  absl::btree_set<KeyframeId> of_query;
  for (const Keyframe* keyframe : query_keyframes) of_query.insert(keyframe->id());
  const auto candidate_keyframes =
      Neighbourhood(candidate_view, candidate, options.neighbours, of_query);
  if (query_keyframes.empty() || candidate_keyframes.empty() || query == candidate) return overlap;
  const Side a{query_view, *query_keyframes.front(), query_keyframes,
               PointsSeenBy(query_view, query_keyframes)};
  const Side b{candidate_view, *candidate_keyframes.front(), candidate_keyframes,
               PointsSeenBy(candidate_view, candidate_keyframes)};
  overlap.verdict = Judge(a, b, options, overlap);
  // A refused overlap says nothing of where the keyframes are.
  if (overlap.IsAccepted()) return overlap;
  overlap.candidate_from_query = Similarity3d::Identity();
  overlap.inliers.clear();
  return overlap;
}

}  // namespace corbslam
