#include "client_agent/shared/pinned_keyframes.h"

#include <utility>

#include "slam/features/keypoint.h"

namespace corbslam::client_agent {
namespace {

constexpr int kEnoughPoints = 15;
// A bound in standard deviations of a keypoint: it is wider than an inlier's, because maps are
// adjusted later.
constexpr double kMaxDeviations = 4;

bool ProjectsToItsKeypoint(const Keyframe& keyframe, uint32_t index, const MapPoint& point) {
  const Eigen::Vector3d x_in_camera = keyframe.camera_from_map * point.position_in_map;
  if (x_in_camera.z() <= 0) return false;
  const Keypoint& keypoint = keyframe.keypoints()[index];
  const Eigen::Vector2d error = Project(keyframe.camera(), x_in_camera) - keypoint.Pixel();
  return error.squaredNorm() <=
         kMaxDeviations * kMaxDeviations * ScalePyramid::Variance_px2(keypoint.octave);
}

// Returns the own keyframe that shares the most points with the foreign one, if they are enough to
// hold the two together; else invalid.
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

// Returns whether most points that the two share project to where each of the two saw them, as
// `map` has them.
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

bool IsSame(const Rigid3d& a, const Rigid3d& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translation == b.translation;
}

}  // namespace

KeyframeId PinnedKeyframes::PinOf(KeyframeId id) const {
  const auto it = contacts_.find(id);
  return it != contacts_.end() && it->second.agrees ? it->second.own : KeyframeId();
}

bool PinnedKeyframes::IsAsBefore(const Contact& before, const Contact& now) {
  return before.own == now.own && before.shared == now.shared &&
         IsSame(before.foreign_from_map, now.foreign_from_map) &&
         IsSame(before.own_from_map, now.own_from_map);
}

void PinnedKeyframes::Update(const Map& map) {
  std::map<KeyframeId, Contact> contacts;
  for (const auto& [id, foreign] : map.keyframes()) {
    if (id.local_map == own_) continue;
    const KeyframeId own_id = MostSharing(foreign, own_);
    const Keyframe* own = map.FindKeyframe(own_id);
    if (own == nullptr) continue;
    Contact now = {own_id, foreign.covisible.at(own_id), foreign.camera_from_map,
                   own->camera_from_map};
    const auto before = contacts_.find(id);
    now.agrees = before != contacts_.end() && IsAsBefore(before->second, now)
                     ? before->second.agrees
                     : AgreeOnSharedPoints(map, foreign, *own);
    contacts.emplace_hint(contacts.end(), id, std::move(now));
  }
  contacts_ = std::move(contacts);
}

}  // namespace corbslam::client_agent
