// What the comments of a trajectory file say of its columns and poses.
#ifndef CORBSLAM_SLAM_EVALUATION_POSE_HEADER_H_
#define CORBSLAM_SLAM_EVALUATION_POSE_HEADER_H_

#include <optional>
#include <string>

#include "absl/strings/string_view.h"
#include "slam/camera/recorded_camera.h"

namespace corbslam {

struct PoseHeader {
  // The quaternion's columns are w, x, y, z; or x, y, z, w.
  std::optional<bool> is_w_first;
  std::optional<PosesOf> poses_of;
};

// Takes what one comment says; others leave `header` as it is.
void ReadPoseHeader(absl::string_view comment, PoseHeader& header);

// Returns the comment "poses of the body" and so on, which ReadPoseHeader and people understand.
std::string PoseHeaderLine(PosesOf poses_of);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EVALUATION_POSE_HEADER_H_
