// Tells where the global frame lies in the robot's: it differs from place to place, by the drift
// that fusion has taken out of the global layer and the robot's own map still has.
#ifndef CORBSLAM_CLIENT_AGENT_SHARED_PLACING_ANCHORS_H_
#define CORBSLAM_CLIENT_AGENT_SHARED_PLACING_ANCHORS_H_

#include <Eigen/Core>
#include <vector>

#include "slam/geometry/rigid3.h"

namespace corbslam::client_agent {

// The anchors: keyframes of which it is known both where they are in the global frame and in the
// robot's. Not thread-safe.
class PlacingAnchors {
 public:
  void Add(const Rigid3d& camera_from_global, const Rigid3d& local_from_global) {
    centres_in_global_.push_back(CameraCentre(camera_from_global));
    local_from_global_.push_back(local_from_global);
  }

  // Returns the value of the nearest anchor. There must be one. The search looks at every anchor.
  const Rigid3d& LocalFromGlobalAt(const Eigen::Vector3d& position_in_global) const {
    const Eigen::Map<const Eigen::Matrix3Xd> centres(
        centres_in_global_.front().data(), 3, static_cast<Eigen::Index>(centres_in_global_.size()));
    Eigen::Index nearest = 0;
    (centres.colwise() - position_in_global).colwise().squaredNorm().minCoeff(&nearest);
    return local_from_global_[static_cast<size_t>(nearest)];
  }

 private:
  std::vector<Eigen::Vector3d> centres_in_global_;
  std::vector<Rigid3d> local_from_global_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SHARED_PLACING_ANCHORS_H_
