// Judges grey pictures of 16 bits a pixel, of which a camera used 10, 12, 14 or all.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_PICTURES_GREY_DEPTH_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_PICTURES_GREY_DEPTH_H_

#include <opencv2/core/mat.hpp>

#include "absl/types/span.h"
#include "client_agent/source/source_finding.h"

namespace corbslam::client_agent {

struct GreyDepth {
  // The bits of a pixel that are used: 8, 10, 12, 14 or 16. The upper 8 of them are tracked.
  int used_bits = 16;
  // What was assumed, where not all 16 bits are used; the user is to judge it.
  SourceFindings findings;
};

// Makes one decision for a whole source, from pictures spread over it (of both cameras of a pair);
// those that aren't CV_16UC1 are passed over. The brightest pixels decide, but for a few per
// million, which are hot ones. A pure function, for any thread.
GreyDepth DecideGreyDepth(absl::Span<const cv::Mat> sample);

// Returns CV_8UC1: the upper 8 of `used_bits` (8 to 16); what is brighter becomes 255. `grey` is
// CV_8UC1 (returned as it is) or CV_16UC1. A pure function, for any thread.
cv::Mat ScaleGreyTo8(const cv::Mat& grey, int used_bits);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_PICTURES_GREY_DEPTH_H_
