#include "slam/optimisation/bundle_problem.h"

#include <limits>

namespace corbslam {

double ObservationChi2(const BundleProblem& problem, const BundleObservation& observation) {
  const BundlePose& pose = problem.poses[observation.pose];
  const Eigen::Vector3d x = pose.ToCamera(problem.points[observation.point]);
  if (!(x.z() > kMinDepth)) return std::numeric_limits<double>::infinity();
  return ReprojectionResidual(*pose.camera, x, observation.measured).squaredNorm() *
         observation.measured.inverse_variance;
}

}  // namespace corbslam
