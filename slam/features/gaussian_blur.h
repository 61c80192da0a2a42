// Smooths a picture before binary tests.
#ifndef CORBSLAM_SLAM_FEATURES_GAUSSIAN_BLUR_H_
#define CORBSLAM_SLAM_FEATURES_GAUSSIAN_BLUR_H_

#include <opencv2/core/mat.hpp>

namespace corbslam {

// Blurs a CV_8UC1 image of at least 4 x 4 pixels by a Gaussian of 7 x 7 pixels and sigma 2, in
// fixed point (each pass rounds to 8 bits), borders mirrored. `blurred` is allocated when it is not
// of that size; it must not share the image's pixels.
void BlurGaussian7x7(const cv::Mat& image, cv::Mat& blurred);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_FEATURES_GAUSSIAN_BLUR_H_
