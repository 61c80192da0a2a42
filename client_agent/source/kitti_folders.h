// Finds where the parts of a KITTI recording lie.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_KITTI_FOLDERS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_KITTI_FOLDERS_H_

#include <string>

#include "absl/status/statusor.h"
#include "client_agent/source/source_spec.h"

namespace corbslam::client_agent {

struct KittiFolders {
  std::string layout;  // Name for people: "KITTI odometry, grey".
  std::string left;    // Folder of the left camera's pictures.
  std::string right;
  std::string calibration;  // File with the rows of the two cameras.
  std::string left_row;
  std::string right_row;
  std::string times;  // File, which may not be there.
};

// Finds the parts in DIR: image_0 and image_1 (grey) or image_2 and image_3 (colour) with calib.txt
// and times.txt; or, of KITTI's raw recordings, image_00 and image_01, or image_02 and image_03,
// each with data/ and timestamps.txt, and calib_cam_to_cam.txt in DIR or the folder above. Grey
// goes before colour unless ?images=colour says otherwise. Returns NOT_FOUND, saying what was
// looked for, where there is no pair of folders; of `one_camera` the first will do.
absl::StatusOr<KittiFolders> FindKittiFolders(const SourceSpec& spec, bool one_camera);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_KITTI_FOLDERS_H_
