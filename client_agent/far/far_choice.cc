#include "client_agent/far/far_choice.h"

#include <algorithm>

#include "absl/container/flat_hash_set.h"

namespace corbslam::client_agent {
namespace {

// The robot goes on by this share of its reach before another choice is made: far less than that
// is between where it is and where its memory ends.
constexpr double kStepOfReach = 0.15;

}  // namespace

FarChoice FarChooser::Choose(const FarIndex& index,
                             const std::map<KeyframeId, std::vector<MapPointId>>& told,
                             const Eigen::Vector3d& centre,
                             const std::optional<Eigen::Vector3d>& recognised, bool anew) {
  FarChoice choice;
  if (!anew && at_.has_value() && (centre - *at_).norm() < step_) return choice;
  at_ = centre;
  std::vector<Eigen::Vector3d> points = {centre};
  if (recognised.has_value()) points.push_back(*recognised);
  const std::vector<FarIndex::Near> near =
      index.Nearest(points, reach_.radius, reach_.max_keyframes);
  const bool is_full = near.size() == reach_.max_keyframes && !near.empty();
  step_ = kStepOfReach * (is_full ? near.back().distance : reach_.radius);
  absl::flat_hash_set<KeyframeId> wanted;
  for (const FarIndex::Near& keyframe : near) {
    wanted.insert(keyframe.id);
    if (!told.contains(keyframe.id)) choice.bring[keyframe.id.local_map].push_back(keyframe.id);
  }
  for (const auto& [id, points_of_it] : told) {
    if (!wanted.contains(id)) choice.take_out.push_back(id);
  }
  return choice;
}

}  // namespace corbslam::client_agent
