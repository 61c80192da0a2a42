// Finds out where and when depth images were taken, against their pictures.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_DEPTH_ALIGNMENT_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_DEPTH_ALIGNMENT_H_

#include <array>
#include <cstddef>
#include <opencv2/core/types.hpp>
#include <vector>

#include "client_agent/source_checks/sample.h"

namespace corbslam::client_agent {

// A hypothesis: depth images are those of `late_frames` earlier, and their outlines lie by
// `offset_px` beside those of the pictures (seen from elsewhere, or not registered).
struct DepthAlignment {
  double late_frames = 0;
  cv::Point2d offset_px;
  // How much stronger grey edges are along the outlines, so moved, than everywhere: 1 by chance.
  double agreement = 0;
};

// What the frames of a sample, or of a part of it, say of where depth images lie.
struct OffsetEvidence {
  // Frames that have outlines, and a neighbour that tells how the picture moves.
  size_t frames = 0;
  DepthAlignment now;   // Best of the hypotheses that are late by less than a frame.
  DepthAlignment here;  // Best of those that also have an offset of a few pixels at most.
};

struct AlignmentEvidence : OffsetEvidence {
  double motion_px = 0;  // Median motion of the picture from frame to frame.
  DepthAlignment best;   // Best of all hypotheses.
  // The same of the first half of the frames, and of the second: depth that is not registered lies
  // elsewhere beside what is near than beside what is far.
  std::array<OffsetEvidence, 2> halves;
};

// Tries delays of up to four frames either way and offsets of up to 24 pixels on the whole sample.
AlignmentEvidence AlignDepth(const Sample& sample);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_DEPTH_ALIGNMENT_H_
