// What a depth image says by itself, and about its picture.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_DEPTH_EVIDENCE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_DEPTH_EVIDENCE_H_

#include <opencv2/core/mat.hpp>
#include <vector>

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

// Finds pixels on the near side of a step in depth: the outlines of things, which a picture taken
// by the same eye at the same time shows too.
std::vector<cv::Point> FindDepthEdges(const cv::Mat& depth);

// Returns how strongly grey values change at each pixel, 0 to 255, against their surroundings:
// CV_8UC1.
cv::Mat MeasureGreyEdges(const cv::Mat& grey);

// Returns the mean of `grey_edges` at `depth_edges` moved by `shift`, over its mean everywhere:
// above 1 where outlines and edges coincide. 0 with too few of them in the picture.
double EdgeAgreement(const std::vector<cv::Point>& depth_edges, const cv::Mat& grey_edges,
                     const cv::Point& shift);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_DEPTH_EVIDENCE_H_
