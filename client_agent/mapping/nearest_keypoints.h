// Chooses keypoints with a depth good enough to make a point from one view.
#ifndef CORBSLAM_CLIENT_AGENT_MAPPING_NEAREST_KEYPOINTS_H_
#define CORBSLAM_CLIENT_AGENT_MAPPING_NEAREST_KEYPOINTS_H_

#include <cstdint>
#include <vector>

#include "slam/camera/camera.h"
#include "slam/features/keypoint.h"

namespace corbslam::client_agent {

// Returns the indices of keypoints with depth, nearest first: all within the camera's close depth,
// and as many farther ones as it takes to have `at_least` (ORB-SLAM2, T-RO 2017).
std::vector<uint32_t> NearestKeypoints(const Camera& camera, const std::vector<Keypoint>& keypoints,
                                       size_t at_least);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_MAPPING_NEAREST_KEYPOINTS_H_
