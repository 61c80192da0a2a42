#include "map_store/retiring/landmark_sights.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "slam/matching/match_point.h"

namespace corbslam::map_store {
namespace {

constexpr int kMatchOctaves = 2;

enum class Visibility { kSees, kMisses, kCantTell };

struct Judgement {
  Visibility visibility = Visibility::kCantTell;
  int octave = 0;
};

// Judges what one keyframe sees of landmarks that it doesn't observe.
class KeyframeJudge {
 public:
  // `knows_depth`: the keyframe's disparities are in the units of the map.
  KeyframeJudge(const Map& map, const Keyframe& keyframe, bool knows_depth,
                const SightOptions& options)
      : map_(map), keyframe_(keyframe), knows_depth_(knows_depth), options_(options) {}

  Judgement Judge(const MapPoint& point) {
    const Camera& camera = keyframe_.camera();
    const auto view = PredictView(point, camera, keyframe_.camera_from_map);
    if (!view.has_value() || keyframe_.descriptors().empty()) return {};
    const Eigen::Vector3d x_in_camera = keyframe_.camera_from_map * point.position_in_map;
    if (const std::optional<Judgement> match = Match(point, *view)) return *match;
    const bool misses = IsWellInside(*view) && IsInRange(point, x_in_camera.norm()) &&
                        view->view_cosine >= options_.min_view_cosine &&
                        IsOpen(view->pixel, x_in_camera.z());
    return {misses ? Visibility::kMisses : Visibility::kCantTell, 0};
  }

 private:
  // Returns nullopt if no keypoint where the point should be looks at all like it.
  std::optional<Judgement> Match(const MapPoint& point, const PredictedView& view) {
    FindNear(view.pixel, options_.radius_px * ScalePyramid::Scale(view.octave),
             view.octave - kMatchOctaves, view.octave + kMatchOctaves);
    int best = options_.min_other_distance;
    Judgement judgement;
    for (const uint32_t i : near_) {
      const int distance = HammingDistance(point.descriptor, keyframe_.descriptors()[i]);
      if (distance >= best) continue;
      best = distance;
      judgement.octave = keyframe_.keypoints()[i].octave;
    }
    if (best == options_.min_other_distance) return std::nullopt;
    if (best <= options_.max_distance) judgement.visibility = Visibility::kSees;
    return judgement;
  }

  bool IsWellInside(const PredictedView& view) const {
    const Camera& camera = keyframe_.camera();
    const double margin = options_.margin_share * camera.width_px;
    return view.pixel.x() >= margin && view.pixel.y() >= margin &&
           view.pixel.x() < camera.width_px - margin && view.pixel.y() < camera.height_px - margin;
  }

  static bool IsInRange(const MapPoint& point, double distance) {
    return distance >= point.min_distance && distance <= point.max_distance;
  }

  // Returns whether nothing near the pixel is seen before this depth, and the picture has keypoints
  // there at all.
  bool IsOpen(const Eigen::Vector2d& pixel, double depth) {
    const double fx_px = keyframe_.camera().fx_px;
    FindNear(pixel, options_.hiding_rad * fx_px, 0, ScalePyramid::kLevels);
    for (const uint32_t i : near_) {
      const std::optional<double> seen = DepthOf(i);
      if (seen.has_value() && *seen < options_.hiding_share * depth) return false;
    }
    FindNear(pixel, options_.lit_rad * fx_px, 0, ScalePyramid::kLevels);
    return !near_.empty();
  }

  std::optional<double> DepthOf(uint32_t keypoint) const {
    if (const MapPoint* point = map_.FindPoint(keyframe_.points[keypoint])) {
      return (keyframe_.camera_from_map * point->position_in_map).z();
    }
    const Keypoint& seen = keyframe_.keypoints()[keypoint];
    if (!knows_depth_ || !seen.HasDepth()) return std::nullopt;
    return DepthFromDisparity(keyframe_.camera(), seen.disparity_px);
  }

  void FindNear(const Eigen::Vector2d& pixel, double radius_px, int min_octave, int max_octave) {
    near_.clear();
    keyframe_.payload->grid.FindNear(keyframe_.keypoints(), pixel.x(), pixel.y(), radius_px,
                                     min_octave, max_octave, near_);
  }

  const Map& map_;
  const Keyframe& keyframe_;
  const bool knows_depth_;
  const SightOptions& options_;
  std::vector<uint32_t> near_;
};

bool KnowsDepth(const RetiringView& view, const Keyframe& keyframe) {
  constexpr double kSameScale = 0.01;
  const auto pose = view.poses.find(keyframe.id());
  return keyframe.camera().IsMetric() && pose != view.poses.end() &&
         std::abs(pose->second.scale - 1) < kSameScale;
}

std::vector<const MapPoint*> ListPoints(const RetiringView& view) {
  std::vector<const MapPoint*> points;
  for (const auto& [id, members] : view.landmarks) {
    if (const MapPoint* point = view.map.FindPoint(id)) points.push_back(point);
  }
  std::sort(points.begin(), points.end(),
            [](const MapPoint* a, const MapPoint* b) { return a->id < b->id; });
  return points;
}

}  // namespace

SightsOfLandmarks FindSights(const RetiringView& view, const SightOptions& options) {
  const std::vector<const MapPoint*> points = ListPoints(view);
  SightsOfLandmarks sights;
  for (const MapPoint* point : points)
    sights.emplace_hint(sights.end(), point->id, LandmarkSights());
  for (const auto& [id, keyframe] : view.map.keyframes()) {
    if (!view.closed.contains(id.local_map)) continue;
    KeyframeJudge judge(view.map, keyframe, KnowsDepth(view, keyframe), options);
    auto of_point = sights.begin();
    for (const MapPoint* point : points) {
      LandmarkSights& found = (of_point++)->second;
      if (const auto seen = point->observations.find(id); seen != point->observations.end()) {
        found.seen.push_back({id, keyframe.keypoints()[seen->second].octave, true});
        continue;
      }
      const Judgement judgement = judge.Judge(*point);
      if (judgement.visibility == Visibility::kSees)
        found.seen.push_back({id, judgement.octave, false});
      if (judgement.visibility == Visibility::kMisses) found.missed_by.push_back(id);
    }
  }
  return sights;
}

}  // namespace corbslam::map_store
