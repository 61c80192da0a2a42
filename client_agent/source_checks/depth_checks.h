// Checks whether depth images are those of their pictures.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_DEPTH_CHECKS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_DEPTH_CHECKS_H_

#include <opencv2/core/mat.hpp>

#include "client_agent/source/source_finding.h"
#include "client_agent/source_checks/sample.h"

namespace corbslam::client_agent {

// Shares are of all pixels. Depths are in metres, of the pixels that have one (0 where none has).
struct DepthStatistics {
  double valid_share = 0;      // Share that is neither 0, NaN nor 65535.
  double saturated_share = 0;  // Share that is 65535.
  double near_m = 0;           // 5 % of the depths are smaller.
  double median_m = 0;
  double far_m = 0;          // 5 % are larger.
  bool is_constant = false;  // All valid pixels have one value.
};

// Measures every third pixel in each direction. `depth` is CV_16UC1 or CV_32FC1.
DepthStatistics MeasureDepth(const cv::Mat& depth, double units_per_m);

// Finds empty, constant or saturated depth; depth that is of another time, seen from elsewhere, or
// not in proportion to the parallax of its picture; units that make the scene a dolls' house or a
// cathedral. A wrong unit within those limits can't be known from pictures: a scene twice as far,
// through which a camera moves twice as fast, looks the same. Pure; any thread.
SourceFindings CheckDepth(const RgbdCalibration& calibration, const Sample& sample);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_DEPTH_CHECKS_H_
