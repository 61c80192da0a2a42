#include "services/client/store/driven_way.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace corbslam::services {
namespace {

// A robot that turns on the spot makes many keyframes there: so large a part of its steps may be
// short.
constexpr double kPart = 0.75;
// Usual steps: what is nearer is joined however the robot turned, what is farther never is. The
// viewer's page draws by the same rule (model/step.ts).
constexpr double kNearSteps = 4;
constexpr double kFarSteps = 12;
constexpr double kMostTurn_rad = 2.8;

}  // namespace

DrivenPath PiecesOf(const ServedTrajectory& served) {
  DrivenPath pieces;
  const ServedPose* before = nullptr;
  for (const ServedPose& pose : served) {
    if (before == nullptr || pose.after_gap || pose.local_map != before->local_map ||
        pose.island != before->island) {
      pieces.emplace_back();
    }
    pieces.back().push_back(pose.frame_from_camera.translation);
    before = &pose;
  }
  return pieces;
}

double UsualStep(const std::map<KeyframeId, Rigid3d>& world_from_camera) {
  std::vector<double> steps;
  const std::pair<const KeyframeId, Rigid3d>* before = nullptr;
  for (const auto& entry : world_from_camera) {
    if (before != nullptr && before->first.local_map == entry.first.local_map) {
      const double numbers =
          static_cast<double>(entry.first.index) - static_cast<double>(before->first.index);
      steps.push_back((entry.second.translation - before->second.translation).norm() / numbers);
    }
    before = &entry;
  }
  if (steps.empty()) return 0;
  const auto at = static_cast<std::ptrdiff_t>(kPart * static_cast<double>(steps.size()));
  std::nth_element(steps.begin(), steps.begin() + at, steps.end());
  return steps[static_cast<size_t>(at)];
}

bool IsGap(const Rigid3d& from, const Rigid3d& to, double usual_step) {
  const double length = (to.translation - from.translation).norm();
  if (usual_step <= 0 || length <= kNearSteps * usual_step) return false;
  if (length > kFarSteps * usual_step) return true;
  const double turn = std::min(from.rotation.angularDistance(to.rotation), kMostTurn_rad);
  return length / 2 * std::tan(turn / 2) > usual_step;
}

}  // namespace corbslam::services
