// Checks whether the pictures of a source are pictures of anything (docs/sources_checks.md has
// every code, the statistic behind it and the measurements behind its limit).
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_PICTURE_CHECKS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_PICTURE_CHECKS_H_

#include <opencv2/core/mat.hpp>

#include "client_agent/source/source_finding.h"
#include "client_agent/source_checks/sample.h"

namespace corbslam::client_agent {

// Grey levels; shares are of the pixels.
struct PictureStatistics {
  int dark = 0;  // 1 % of the pixels are darker.
  int median = 0;
  int bright = 0;  // 1 % are brighter.
  int least = 0;
  int most = 0;
  double white_share = 0;  // Share of the pixels at 255.

  int Contrast() const { return bright - dark; }
  bool IsConstant() const { return least == most; }
};

// Measures every second pixel of every second row of a CV_8UC1 picture that isn't empty.
PictureStatistics MeasurePicture(const cv::Mat& grey);

// Returns whether two pictures are the same to the byte.
bool AreSame(const cv::Mat& a, const cv::Mat& b);

// Checks size, darkness, saturation, contrast, and pictures that repeat: in time, or in both
// cameras of a pair. What holds for a few frames alone (a shutter that opens, a tunnel) is no
// finding. Pure; any thread.
SourceFindings CheckPictures(const SensorCalibration& calibration, const Sample& sample);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_PICTURE_CHECKS_H_
