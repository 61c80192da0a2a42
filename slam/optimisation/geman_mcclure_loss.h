// A loss that forgets what is far off.
#ifndef CORBSLAM_SLAM_OPTIMISATION_GEMAN_MCCLURE_LOSS_H_
#define CORBSLAM_SLAM_OPTIMISATION_GEMAN_MCCLURE_LOSS_H_

#include <ceres/loss_function.h>

namespace corbslam {

// Of a squared error s: max * s / (max + s). It is s for small errors and at most `max`; the pull
// of a gross error goes to zero but is never zero. Not convex: begin near the minimum. Source:
// Geman and McClure, "Bayesian image analysis: an application to single photon emission
// tomography", 1985.
class GemanMcClureLoss : public ceres::LossFunction {
 public:
  explicit GemanMcClureLoss(double max) : max_(max) {}

  void Evaluate(double s, double rho[3]) const override {
    const double share = max_ / (max_ + s);
    rho[0] = share * s;
    rho[1] = share * share;
    rho[2] = -2 * rho[1] / (max_ + s);
  }

 private:
  double max_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_GEMAN_MCCLURE_LOSS_H_
