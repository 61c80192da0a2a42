// Measures how far away what a keyframe sees is: the unit in which a camera's motion shows in its
// picture.
#ifndef CORBSLAM_SLAM_MAP_SCENE_DEPTH_H_
#define CORBSLAM_SLAM_MAP_SCENE_DEPTH_H_

#include <optional>

#include "absl/types/span.h"
#include "slam/map/map.h"

namespace corbslam {

// Returns the median depth, in the map's units, of those of the points that are in the map and
// before the keyframe's camera; none where there is none.
std::optional<double> MedianDepth(const Map& map, const Keyframe& keyframe,
                                  absl::Span<const MapPointId> points);
// Returns the median depth of all points that the keyframe sees.
std::optional<double> MedianDepth(const Map& map, const Keyframe& keyframe);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_MAP_SCENE_DEPTH_H_
