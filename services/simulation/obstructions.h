// What comes between the world and a camera's imager for a while.
#ifndef CORBSLAM_SERVICES_SIMULATION_OBSTRUCTIONS_H_
#define CORBSLAM_SERVICES_SIMULATION_OBSTRUCTIONS_H_

#include <opencv2/core/mat.hpp>

namespace corbslam {

// Both change light (CV_32FC1) in place, and leave it as it is at 0.

// Blurs by a standard deviation in pixels, as a lens that is not in focus.
void Defocus(double deviation_px, cv::Mat& light);

// Puts a hand before the lens, dark and out of focus, that reaches from the right over this share
// of the picture; 1 covers all of it.
void CoverByHand(double share, cv::Mat& light);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_OBSTRUCTIONS_H_
