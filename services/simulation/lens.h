// What lens and imager do to the light before it is a grey level.
#ifndef CORBSLAM_SERVICES_SIMULATION_LENS_H_
#define CORBSLAM_SERVICES_SIMULATION_LENS_H_

#include <cstdint>
#include <opencv2/core/mat.hpp>

namespace corbslam {

struct Lens {
  double exposure = 1.5;        // Multiplies the light; at 1 a white surface in the sun is white.
  double exposure_drift = 0.0;  // Swings the exposure by this share, slowly, over the sequence.
  double vignetting = 0.1;      // Share of light that is missing in the corners.
  double blur_px = 0.5;         // Standard deviation of the lens's blur.
  double read_noise = 1.0;      // Standard deviation in grey levels, everywhere.
  double shot_noise = 1.0;      // Standard deviation in grey levels of a white pixel.
  uint64_t noise_seed = 1;
};

// Turns light (CV_32FC1, 1: white) into grey levels (CV_8UC1), 255 for white. `time_s` drives the
// exposure's drift; each `stream` has noise of its own, the same every time.
cv::Mat Develop(const cv::Mat& light, const Lens& lens, double time_s, uint64_t stream,
                int threads);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_LENS_H_
