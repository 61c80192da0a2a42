// Implements Map's methods that derive a point's appearance from its observations.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "slam/map/map.h"

namespace corbslam {
namespace {

// Returns the median of the distances from `descriptors[i]` to all of them.
int MedianDistance(const std::vector<const Descriptor*>& descriptors, size_t i,
                   std::vector<int>& distances) {
  distances.clear();
  for (const Descriptor* other : descriptors) {
    distances.push_back(HammingDistance(*descriptors[i], *other));
  }
  const auto middle = distances.begin() + static_cast<ptrdiff_t>((distances.size() - 1) / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

size_t IndexOfLeastMedianDistance(const std::vector<const Descriptor*>& descriptors) {
  size_t best = 0;
  int best_median = std::numeric_limits<int>::max();
  std::vector<int> distances;
  for (size_t i = 0; i < descriptors.size(); ++i) {
    const int median = MedianDistance(descriptors, i, distances);
    if (median >= best_median) continue;
    best_median = median;
    best = i;
  }
  return best;
}

}  // namespace

void Map::UpdatePointGeometry(MapPointId id) {
  MapPoint* point = points_.Find(id);
  if (point == nullptr || point->observations.empty()) return;
  if (!point->observations.contains(point->reference)) {
    point->reference = point->observations.begin()->first;
  }
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& [keyframe_id, keypoint] : point->observations) {
    const Keyframe& keyframe = *FindKeyframe(keyframe_id);
    sum += (point->position_in_map - CameraCentre(keyframe.camera_from_map)).normalized();
  }
  point->normal_in_map = sum.normalized();
  const Keyframe& reference = *FindKeyframe(point->reference);
  const int octave = reference.keypoints()[point->observations.at(point->reference)].octave;
  const double distance = (point->position_in_map - CameraCentre(reference.camera_from_map)).norm();
  point->max_distance = distance * ScalePyramid::Scale(octave);
  point->min_distance = point->max_distance / ScalePyramid::Scale(ScalePyramid::kLevels - 1);
}

void Map::UpdatePointAppearance(MapPointId id) {
  MapPoint* point = points_.Find(id);
  if (point == nullptr || point->observations.empty()) return;
  std::vector<const Descriptor*> descriptors;
  for (const auto& [keyframe_id, keypoint] : point->observations) {
    const Keyframe& keyframe = *FindKeyframe(keyframe_id);
    if (keypoint < keyframe.descriptors().size()) {
      descriptors.push_back(&keyframe.descriptors()[keypoint]);
    }
  }
  if (!descriptors.empty()) {
    point->descriptor = *descriptors[IndexOfLeastMedianDistance(descriptors)];
  }
  UpdatePointGeometry(id);
}

void Map::SetPointAppearance(MapPointId id, const Descriptor& descriptor,
                             const Eigen::Vector3d& normal_in_map, double min_distance,
                             double max_distance, KeyframeId reference) {
  MapPoint* point = points_.Find(id);
  if (point == nullptr) return;
  point->descriptor = descriptor;
  point->normal_in_map = normal_in_map;
  point->min_distance = min_distance;
  point->max_distance = max_distance;
  point->reference = reference;
}

}  // namespace corbslam
