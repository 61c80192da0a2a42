// Judges grey pictures of 16 bits a pixel, of which a camera used 10, 12, 14 or all.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_PICTURES_GREY_DEPTH_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_PICTURES_GREY_DEPTH_H_

#include <opencv2/core/mat.hpp>

#include "absl/types/span.h"
#include "client_agent/source/source_finding.h"

namespace corbslam::client_agent {

struct GreyDepth {
  // The bits of a pixel that are used: 8, 10, 12, 14 or 16. The upper 8 of them are tracked, ...
  int used_bits = 16;
  // ... unless nearly all of it is dark: then grey levels are so many times as bright, up to 16.
  double gain = 1;
  // What was assumed, where not all 16 bits are used or a gain is; the user is to judge it.
  SourceFindings findings;

  // The value that becomes 256, were there room for it.
  int White() const { return static_cast<int>((1 << used_bits) / gain); }
};

// Makes one decision for a whole source, from pictures spread over it (of both cameras of a pair);
// those that aren't CV_16UC1 are passed over. The brightest pixels decide on the bits, but for a
// few per million, which are hot ones, and all but the brightest hundredth on the gain. A pure
// function, for any thread.
GreyDepth DecideGreyDepth(absl::Span<const cv::Mat> sample);

// Returns CV_8UC1: 256 grey levels up to `white` (GreyDepth::White); what is brighter becomes 255.
// `grey` is CV_8UC1 (returned as it is) or CV_16UC1. A pure function, for any thread.
cv::Mat ScaleGreyTo8(const cv::Mat& grey, int white);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_PICTURES_GREY_DEPTH_H_
