// Draws what the system sees of a camera, so that people see whether it is rectified and aligned.
#ifndef CORBSLAM_SERVICES_TOOL_RIG_RIG_PICTURE_H_
#define CORBSLAM_SERVICES_TOOL_RIG_RIG_PICTURE_H_

#include <opencv2/core/mat.hpp>
#include <vector>

#include "client_agent/source_checks/pair_evidence.h"
#include "client_agent/source_checks/sample.h"

namespace corbslam::services {

// Returns the rectified pair with most matches (CV_8UC3), left beside right, with rows drawn
// through both; matches are joined, green where their rows are at most 0.75 pixels apart, red
// otherwise. `pairs` are those of the sample. Empty without any.
cv::Mat DrawPair(const client_agent::PairPreparation& preparation,
                 const client_agent::Sample& sample,
                 const std::vector<client_agent::JudgedPair>& pairs);

// Returns the middle frame's grey picture beside the same with its depth over it in colours: near
// is red, far is blue, none is left grey. Empty without a frame.
cv::Mat DrawDepth(const client_agent::Sample& sample);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_RIG_RIG_PICTURE_H_
