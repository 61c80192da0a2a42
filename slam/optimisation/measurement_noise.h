// Measures how noisy keypoints really are. What is assumed of them (a pixel of their octave) is
// several times what good cameras have, and bounds made of it let errors of many standard
// deviations pass.
#ifndef CORBSLAM_SLAM_OPTIMISATION_MEASUREMENT_NOISE_H_
#define CORBSLAM_SLAM_OPTIMISATION_MEASUREMENT_NOISE_H_

#include <vector>

#include "slam/optimisation/bundle_problem.h"

namespace corbslam {

// Returns for each pose the variance of its keypoints' noise in units of the assumed one, at most
// 1. It follows from the median error of all observations, or of the pose's own where that is
// larger (the camera moved fast, or is not yet where it belongs). The problem should be at the
// minimum of a robust cost: elsewhere errors are more than noise, and the answer is too large.
std::vector<double> MeasureNoise(const BundleProblem& problem);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_MEASUREMENT_NOISE_H_
