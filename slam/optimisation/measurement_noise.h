// How noisy keypoints really are. What is assumed of them (a pixel of their octave) is several
// times what good cameras have, and bounds made of it let errors of many standard deviations pass.
#ifndef CORBSLAM_SLAM_OPTIMISATION_MEASUREMENT_NOISE_H_
#define CORBSLAM_SLAM_OPTIMISATION_MEASUREMENT_NOISE_H_

#include <vector>

#include "slam/optimisation/bundle_problem.h"

namespace corbslam {

// Of each pose, the variance of its keypoints' noise in units of the assumed one, at most 1: by the
// median error, of all observations or of its own where that is larger (it moved fast, or is not
// yet where it belongs). The problem should be at the minimum of a robust cost: errors elsewhere
// are more than noise, and the answer the larger.
std::vector<double> MeasureNoise(const BundleProblem& problem);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_MEASUREMENT_NOISE_H_
