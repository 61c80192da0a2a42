// Makes of true depths what a depth camera would see.
#ifndef CORBSLAM_SERVICES_SIMULATION_SEQUENCE_DEPTH_IMAGE_H_
#define CORBSLAM_SERVICES_SIMULATION_SEQUENCE_DEPTH_IMAGE_H_

#include <cstdint>
#include <opencv2/core/mat.hpp>

namespace corbslam {

struct DepthImageOptions {
  double units_per_m = 5000;
  double nearest_m = 0.5;
  double farthest_m = 8;
  double noise_m = 1.425e-3;  // Standard deviation at 1 m; it grows with the square of the depth.
  uint64_t noise_seed = 1;
};

// Turns CV_32FC1 in metres into CV_16UC1 in units; 0 outside the range. Each stream has noise of
// its own, the same every time. May throw cv::Exception.
cv::Mat MakeDepthImage(const cv::Mat& depth_m, const DepthImageOptions& options, uint64_t stream);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_SEQUENCE_DEPTH_IMAGE_H_
