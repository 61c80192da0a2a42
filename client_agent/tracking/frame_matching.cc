#include "client_agent/tracking/frame_matching.h"

#include <optional>

#include "absl/container/flat_hash_set.h"
#include "slam/matching/projection_matching.h"
#include "slam/matching/word_matching.h"

namespace corbslam::client_agent {
namespace {

// Sets the octaves on which a keypoint of the previous frame may appear now: coarser ones when the
// camera came nearer, finer ones when it went back by more than its baseline.
void SetOctaves(const Rigid3d& previous_from_now, const Camera& camera, int octave,
                SearchWindow& window) {
  const double forward = previous_from_now.translation.z();
  window.min_octave = octave - 1;
  window.max_octave = octave + 1;
  if (!camera.IsMetric()) return;
  if (forward > camera.baseline_m) {
    window.min_octave = octave;
    window.max_octave = ScalePyramid::kLevels - 1;
  } else if (-forward > camera.baseline_m) {
    window.min_octave = 0;
    window.max_octave = octave;
  }
}

std::optional<SearchWindow> WindowOf(const Frame& previous, size_t keypoint_index,
                                     const Rigid3d& camera_from_map,
                                     const Rigid3d& previous_from_now, double radius_px) {
  const Camera& camera = previous.camera();
  const Association& association = previous.associations[keypoint_index];
  const Eigen::Vector3d x_in_camera = camera_from_map * association.position_in_map;
  if (x_in_camera.z() <= 0) return std::nullopt;
  SearchWindow window;
  window.pixel = Project(camera, x_in_camera);
  if (!IsInImage(camera, window.pixel)) return std::nullopt;
  const Keypoint& keypoint = previous.keypoints()[keypoint_index];
  window.radius_px = radius_px * ScalePyramid::Scale(keypoint.octave);
  if (camera.IsMetric()) window.disparity_px = DisparityFromDepth(camera, x_in_camera.z());
  SetOctaves(previous_from_now, camera, keypoint.octave, window);
  window.descriptor = previous.descriptors()[keypoint_index];
  window.angle_rad = keypoint.angle_rad;
  return window;
}

}  // namespace

int MatchPreviousFrame(const Frame& previous, const Rigid3d& predicted_camera_from_map,
                       double radius_px, Frame& frame) {
  const Rigid3d previous_from_now = previous.camera_from_map * predicted_camera_from_map.Inverse();
  std::vector<SearchWindow> windows;
  std::vector<size_t> seen_by;
  for (size_t i = 0; i < previous.associations.size(); ++i) {
    if (previous.associations[i].kind == Association::Kind::kNone) continue;
    const auto window =
        WindowOf(previous, i, predicted_camera_from_map, previous_from_now, radius_px);
    if (!window.has_value()) continue;
    windows.push_back(*window);
    seen_by.push_back(i);
  }
  const std::vector<uint32_t> matches =
      MatchWindows(windows, *frame.payload, {}, {.check_orientation = true});
  frame.associations.assign(frame.keypoints().size(), {});
  int count = 0;
  for (size_t k = 0; k < matches.size(); ++k) {
    if (matches[k] == kNoMatch) continue;
    frame.associations[matches[k]] = previous.associations[seen_by[k]];
    ++count;
  }
  return count;
}

int MatchKeyframe(const Map& map, const Keyframe& keyframe, Frame& frame) {
  Keyframe view;
  view.payload = frame.payload;
  view.words = frame.words;
  view.points.resize(frame.keypoints().size());
  frame.associations.assign(frame.keypoints().size(), {});
  int count = 0;
  const auto matches = MatchByWords(keyframe, view, {.max_ratio = 0.7, .need_points_b = false});
  for (const auto& [in_keyframe, in_frame] : matches) {
    const MapPoint* point = map.FindPoint(keyframe.points[in_keyframe]);
    if (point == nullptr) continue;
    frame.associations[in_frame] = {Association::Kind::kMapPoint, point->id,
                                    point->position_in_map};
    ++count;
  }
  return count;
}

int MatchLocalPoints(const std::vector<PointInView>& points, double widening, Frame& frame,
                     std::vector<MapPointId>& visible) {
  absl::flat_hash_set<MapPointId> seen;
  std::vector<char> taken(frame.associations.size(), 0);
  for (size_t i = 0; i < frame.associations.size(); ++i) {
    taken[i] = frame.associations[i].kind == Association::Kind::kMapPoint;
    if (!taken[i]) continue;
    seen.insert(frame.associations[i].id);
    visible.push_back(frame.associations[i].id);
  }
  std::vector<SearchWindow> windows;
  std::vector<const MatchPoint*> sought;
  for (const auto& [point, view] : points) {
    if (seen.contains(point.id)) continue;
    visible.push_back(point.id);
    windows.push_back(MakeSearchWindow(point, view, widening));
    sought.push_back(&point);
  }
  const std::vector<uint32_t> matches =
      MatchWindows(windows, *frame.payload, taken, {.max_ratio = 0.8});
  int count = 0;
  for (size_t k = 0; k < matches.size(); ++k) {
    if (matches[k] == kNoMatch) continue;
    frame.associations[matches[k]] = {Association::Kind::kMapPoint, sought[k]->id,
                                      sought[k]->position_in_map};
    ++count;
  }
  return count;
}

}  // namespace corbslam::client_agent
