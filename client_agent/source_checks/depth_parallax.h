// Checks whether features move from one picture to another as their depths say.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_DEPTH_PARALLAX_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_DEPTH_PARALLAX_H_

#include <cstddef>

#include "client_agent/source_checks/sample.h"
#include "slam/sensor/sensor.h"

namespace corbslam::client_agent {

struct ParallaxEvidence {
  // Matches of two pictures that some motion of the camera explains, of features with depth.
  size_t rigid = 0;
  // Matches of these that one pose explains with their depths, and with one depth for all: the more
  // the first number exceeds the second, the more parallax there is.
  size_t with_depths = 0;
  size_t with_one_depth = 0;
};

// `first` has the depth image. Their scale is not judged: poses take it as it is.
ParallaxEvidence CompareParallax(const RgbdCalibration& calibration, const SensorImages& first,
                                 const SensorImages& second);

// Returns the share of matches between the first and the last of consecutive frames that their
// depths explain, of those that one depth for all leaves unexplained; below 0 where depths explain
// less than one depth does. It is 1 where there is too little parallax to judge.
double MeasureParallaxGain(const RgbdCalibration& calibration, const Sample& sample);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_DEPTH_PARALLAX_H_
