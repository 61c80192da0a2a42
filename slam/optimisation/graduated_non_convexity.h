// Graduated non-convexity: outliers lose their say gradually, so that no good start is needed.
#ifndef CORBSLAM_SLAM_OPTIMISATION_GRADUATED_NON_CONVEXITY_H_
#define CORBSLAM_SLAM_OPTIMISATION_GRADUATED_NON_CONVEXITY_H_

#include <ceres/loss_function.h>

#include <cmath>

namespace corbslam {

// The surrogates of truncated least squares, min(s, max) of a squared error s. They are convex at
// first, and come nearer to it the larger `mu` grows. Source: Yang et al., "Graduated Non-Convexity
// for Robust Spatial Perception: From Non-Minimal Solvers to Global Outlier Rejection", RA-L 2020.
class GraduatedTruncation {
 public:
  // `worst`, above `max`, is the largest squared error of the first solution (remark 5).
  GraduatedTruncation(double max, double worst) : max_(max), mu_(max / (2 * worst - max)) {}

  // Returns the weight of a squared error (equation 14): 1 well below `max`, 0 well above.
  double Weight(double s) const {
    if (s <= mu_ / (mu_ + 1) * max_) return 1;
    if (s >= (mu_ + 1) / mu_ * max_) return 0;
    return std::sqrt(max_ * mu_ * (mu_ + 1) / s) - mu_;
  }
  void Sharpen() { mu_ *= 1.4; }

 private:
  const double max_;
  double mu_;
};

// Multiplies a squared residual; changes between solves.
class AdjustableWeight : public ceres::LossFunction {
 public:
  double value() const { return value_; }
  void set_value(double value) { value_ = value; }

  void Evaluate(double s, double rho[3]) const override {
    rho[0] = value_ * s;
    rho[1] = value_;
    rho[2] = 0;
  }

 private:
  double value_ = 1;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_GRADUATED_NON_CONVEXITY_H_
