// How dark, bright and varied a grey picture is.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_PICTURE_STATISTICS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_PICTURE_STATISTICS_H_

#include <opencv2/core/mat.hpp>

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

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_PICTURE_STATISTICS_H_
