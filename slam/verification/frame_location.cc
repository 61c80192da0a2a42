#include "slam/verification/frame_location.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "absl/container/btree_map.h"
#include "absl/container/flat_hash_set.h"
#include "slam/matching/word_matching.h"
#include "slam/optimisation/pose_covariance.h"
#include "slam/solvers/pnp_ransac.h"
#include "slam/verification/neighbourhood.h"
#include "slam/verification/projection_search.h"

namespace corbslam {
namespace {

constexpr size_t kMaxAnswering = 10;
constexpr int kRansacIterations = 600;
// The first guided search is wide: RANSAC's pose is of few points.
constexpr double kFirstRadius_px = 10;
constexpr double kLastRadius_px = 5;

// A feature of the picture and the point that it may see.
struct Sight {
  uint32_t keypoint = 0;
  const MapPoint* point = nullptr;
};

struct Votes {
  int count = 0;
  int distance = 257;
};

// Elects for each feature, and for each point, at most one partner: the pair that most keyframes
// propose, then the nearest.
std::vector<Sight> MatchByDescriptors(const Map& view,
                                      const std::vector<const Keyframe*>& keyframes,
                                      const Keyframe& frame) {
  absl::btree_map<std::pair<uint32_t, MapPointId>, Votes> votes;
  for (const Keyframe* keyframe : keyframes) {
    for (const auto& [i, j] : MatchByWords(frame, *keyframe, {.need_points_a = false})) {
      Votes& vote = votes[{i, keyframe->points[j]}];
      ++vote.count;
      vote.distance = std::min(vote.distance,
                               HammingDistance(frame.descriptors()[i], keyframe->descriptors()[j]));
    }
  }
  std::vector<std::pair<std::pair<uint32_t, MapPointId>, Votes>> ranked(votes.begin(), votes.end());
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) {
    return std::tuple(-a.second.count, a.second.distance) <
           std::tuple(-b.second.count, b.second.distance);
  });
  absl::flat_hash_set<uint32_t> taken_keypoints;
  absl::flat_hash_set<MapPointId> taken_points;
  std::vector<Sight> sights;
  for (const auto& [pair, vote] : ranked) {
    const MapPoint* point = view.FindPoint(pair.second);
    if (point == nullptr || taken_keypoints.contains(pair.first)) continue;
    if (!taken_points.insert(pair.second).second) continue;
    taken_keypoints.insert(pair.first);
    sights.push_back({pair.first, point});
  }
  return sights;
}

std::vector<PoseObservation> Observe(const Keyframe& frame, const std::vector<Sight>& sights) {
  std::vector<PoseObservation> observations;
  observations.reserve(sights.size());
  for (const Sight& sight : sights) {
    const Keypoint& keypoint = frame.keypoints()[sight.keypoint];
    observations.push_back({sight.point->position_in_map, keypoint.Pixel(),
                            static_cast<double>(keypoint.disparity_px),
                            ScalePyramid::Variance_px2(keypoint.octave)});
  }
  return observations;
}

void KeepInliers(const PoseEstimate& estimate, std::vector<Sight>& sights) {
  size_t kept = 0;
  for (size_t i = 0; i < sights.size(); ++i) {
    if (estimate.is_inlier[i]) sights[kept++] = sights[i];
  }
  sights.resize(kept);
}

std::vector<KeyframeId> KeyframesThatSee(const std::vector<Sight>& sights) {
  absl::btree_map<KeyframeId, int> counts;
  for (const Sight& sight : sights) {
    for (const auto& [keyframe, keypoint] : sight.point->observations) ++counts[keyframe];
  }
  std::vector<std::pair<KeyframeId, int>> ranked(counts.begin(), counts.end());
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  std::vector<KeyframeId> ids;
  for (const auto& [id, count] : ranked) {
    if (ids.size() == kMaxAnswering) break;
    ids.push_back(id);
  }
  return ids;
}

// Searches, guided, in a shrinking radius, and takes the pose that all that is found agrees on.
// Sets `result.inliers` and the pose; returns the inliers.
std::vector<Sight> Refine(const Keyframe& frame, const std::vector<const MapPoint*>& points,
                          LocateFrameResult& result) {
  std::vector<Sight> sights;
  for (const double radius_px : {kFirstRadius_px, kLastRadius_px}) {
    sights.clear();
    for (const ProjectionMatch& match :
         FindByProjection(points, frame, result.camera_from_map, {.radius_px = radius_px})) {
      sights.push_back({match.keypoint, points[match.point]});
    }
    const PoseEstimate estimate =
        OptimisePose(frame.camera(), result.camera_from_map, Observe(frame, sights));
    result.camera_from_map = estimate.camera_from_map;
    result.inliers = estimate.inliers;
    KeepInliers(estimate, sights);
  }
  return sights;
}

// Sets the stage and the covariance, or the camera that the points agree with.
void JudgeCamera(const Keyframe& frame, const std::vector<const MapPoint*>& points,
                 const std::vector<PoseObservation>& agreeing,
                 const std::vector<PoseObservation>& looks_alike,
                 const FrameLocationOptions& options, LocateFrameResult& result) {
  std::optional<Matrix6d> covariance =
      PoseCovariance(frame.camera(), result.camera_from_map, agreeing);
  result.stage = LocateStage::kLocated;
  if (options.check_camera) {
    const CameraCheck check =
        CheckCamera(frame, points, result.camera_from_map, agreeing, looks_alike, options.camera);
    if (check.verdict == CameraCheck::Verdict::kAnother) {
      result.stage = LocateStage::kFewInliers;
      result.fitting_camera = check.fit->camera;
      return;
    }
    if (check.verdict == CameraCheck::Verdict::kInDoubt) {
      result.stage = LocateStage::kCameraInDoubt;
      return;
    }
    if (covariance.has_value()) *covariance += *check.covariance;
  }
  if (covariance.has_value()) result.covariance = InMapAxes(result.camera_from_map, *covariance);
}

LocateFrameResult TryCandidate(const Keyframe& frame, const Map& view, KeyframeId candidate,
                               const FrameLocationOptions& options) {
  LocateFrameResult result;
  const std::vector<const Keyframe*> keyframes = Neighbourhood(view, candidate, options.neighbours);
  if (keyframes.empty()) return result;
  const std::vector<Sight> alike = MatchByDescriptors(view, keyframes, frame);
  result.word_matches = static_cast<int>(alike.size());
  result.stage = LocateStage::kFewMatches;
  if (result.word_matches < options.min_word_matches) return result;

  result.stage = LocateStage::kNoPose;
  const std::vector<PoseObservation> looks_alike = Observe(frame, alike);
  const auto estimate =
      EstimatePose(frame.camera(), looks_alike,
                   {.min_inliers = 4, .max_iterations = kRansacIterations, .seed = options.seed});
  if (!estimate.ok()) return result;
  result.pose_inliers = estimate->inliers;
  if (result.pose_inliers < options.min_pose_inliers) return result;

  result.stage = LocateStage::kFewInliers;
  result.camera_from_map = estimate->camera_from_map;
  const std::vector<const MapPoint*> points = PointsSeenBy(view, keyframes);
  const std::vector<Sight> inliers = Refine(frame, points, result);
  const InliersNeeded rule = CountInliersNeeded(frame, points, result.camera_from_map, options);
  result.inliers_needed = rule.needed;
  result.visible_points = rule.visible;
  result.chance_inliers = rule.by_chance;
  if (result.inliers < result.inliers_needed) return result;
  JudgeCamera(frame, points, Observe(frame, inliers), looks_alike, options, result);
  if (result.stage == LocateStage::kLocated) result.keyframes = KeyframesThatSee(inliers);
  return result;
}

}  // namespace

InliersNeeded CountInliersNeeded(const Keyframe& frame, const std::vector<const MapPoint*>& points,
                                 const Rigid3d& camera_from_map,
                                 const FrameLocationOptions& options) {
  const size_t by_chance =
      MeanByChance(points, frame, camera_from_map, {.radius_px = kLastRadius_px});
  const size_t visible = CountVisible(points, frame, camera_from_map);
  const double needed = std::max({static_cast<double>(options.min_inliers),
                                  options.min_inliers_to_chance * static_cast<double>(by_chance),
                                  options.min_inliers_to_visible * static_cast<double>(visible)});
  return {static_cast<int>(std::ceil(needed)), static_cast<int>(visible),
          static_cast<int>(by_chance)};
}

LocateFrameResult LocateFrame(const LocateFrameRequest& request,
                              const FrameLocationOptions& options,
                              const std::function<bool(double)>& goes_on) {
  LocateFrameResult best;
  if (request.frame.keypoints().size() < options.min_features) {
    best.stage = LocateStage::kFewFeatures;
  } else {
    for (size_t i = 0; i < request.candidates.size(); ++i) {
      const double done = static_cast<double>(i) / static_cast<double>(request.candidates.size());
      if (goes_on != nullptr && !goes_on(done)) break;
      LocateFrameResult tried =
          TryCandidate(request.frame, request.view, request.candidates[i].id, options);
      // Another candidate, of fewer points, might not show that the camera is another one.
      const bool is_anothers = tried.fitting_camera.has_value();
      if (is_anothers || GotFarther(tried, best)) best = std::move(tried);
      if (is_anothers || best.stage == LocateStage::kLocated) break;
    }
  }
  // A pose that was not believed says nothing of where the picture was taken.
  if (best.stage != LocateStage::kLocated) best.camera_from_map = Rigid3d();
  best.base_revision = request.base_revision;
  return best;
}

}  // namespace corbslam
