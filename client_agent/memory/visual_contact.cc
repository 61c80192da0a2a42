#include "client_agent/memory/visual_contact.h"

#include <algorithm>

#include "slam/features/keypoint.h"

namespace corbslam {
namespace {

constexpr int kEnoughPoints = 15;
// Of a keypoint's own deviation: wider than an inlier's, for maps are adjusted later.
constexpr double kMaxDeviations = 4;

bool ProjectsToItsKeypoint(const Keyframe& keyframe, uint32_t index, const MapPoint& point) {
  const Eigen::Vector3d x_in_camera = keyframe.camera_from_map * point.position_in_map;
  if (x_in_camera.z() <= 0) return false;
  const Keypoint& keypoint = keyframe.keypoints()[index];
  const Eigen::Vector2d error = Project(keyframe.camera(), x_in_camera) - keypoint.Pixel();
  return error.squaredNorm() <=
         kMaxDeviations * kMaxDeviations * ScalePyramid::Variance_px2(keypoint.octave);
}

}  // namespace

KeyframeId MostSharing(const Keyframe& foreign, LocalMapId own) {
  KeyframeId best;
  int most = kEnoughPoints - 1;
  for (const auto& [id, shared] : foreign.covisible) {
    if (id.local_map != own || shared <= most) continue;
    best = id;
    most = shared;
  }
  return best;
}

bool AgreeOnSharedPoints(const Map& map, const Keyframe& foreign, const Keyframe& own) {
  int shared = 0;
  int agreed = 0;
  for (uint32_t k = 0; k < foreign.points.size(); ++k) {
    const MapPoint* point =
        foreign.points[k].IsValid() ? map.FindPoint(foreign.points[k]) : nullptr;
    if (point == nullptr) continue;
    const auto seen = point->observations.find(own.id());
    if (seen == point->observations.end()) continue;
    ++shared;
    agreed += ProjectsToItsKeypoint(foreign, k, *point) &&
              ProjectsToItsKeypoint(own, seen->second, *point);
  }
  return 2 * agreed > shared;
}

}  // namespace corbslam
