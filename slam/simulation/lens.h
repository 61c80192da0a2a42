// What lens and imager do to the light before it is a grey level.
#ifndef CORBSLAM_SLAM_SIMULATION_LENS_H_
#define CORBSLAM_SLAM_SIMULATION_LENS_H_

#include <cstdint>

namespace corbslam {

struct Lens {
  double exposure = 1.0;        // Multiplies the light; 1: a white surface in the sun is white.
  double exposure_drift = 0.0;  // Swings the exposure by this share, slowly, over the sequence.
  double gamma = 0.7;           // grey = 255 light^gamma.
  double vignetting = 0.1;      // Share of light that is missing in the corners.
  double read_noise = 1.0;      // Standard deviation in grey levels, everywhere.
  double shot_noise = 1.0;      // Standard deviation in grey levels of a white pixel.
  int motion_blur_samples = 1;  // Pictures averaged while the shutter is open; 1: none.
  uint64_t noise_seed = 1;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SIMULATION_LENS_H_
