// Holds what an adjustment of one camera's pictures alone leaves free: the size of it all.
#ifndef CORBSLAM_SLAM_OPTIMISATION_SCALE_GAUGE_H_
#define CORBSLAM_SLAM_OPTIMISATION_SCALE_GAUGE_H_

#include <optional>

#include "slam/optimisation/bundle_problem.h"

namespace corbslam {

// Where nothing measures a depth and one pose alone is fixed, every size explains the pixels as
// well, and where a minimiser ends among them is chance. Made before the problem is minimised.
class ScaleGauge {
 public:
  explicit ScaleGauge(const BundleProblem& problem);

  // Returns whether the problem has no size of its own.
  bool is_free() const { return extent_.has_value(); }
  // Scales what moves about the fixed camera, so that the free cameras are as far from it, in the
  // root of the mean square, as before. No pixel changes. Does nothing unless is_free().
  void Hold(BundleProblem& problem) const;

 private:
  std::optional<double> extent_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_SCALE_GAUGE_H_
