// Makes a rig of what ROS says of two cameras: their CameraInfo and the robot's fixed frames.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_CAMERA_INFO_RIG_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_CAMERA_INFO_RIG_H_

#include <string>

#include "absl/status/statusor.h"
#include "client_agent/source/bag/bag_options.h"
#include "client_agent/source/bag/messages/transforms.h"
#include "client_agent/source/bag/rig_choice.h"
#include "client_agent/source/rig/rig.h"
#include "client_agent/source/source_finding.h"

namespace corbslam::client_agent {

struct CameraInfoRig {
  Rig rig;
  std::string from;  // The topics, for people.
  std::string depth_units_from;
  SourceFindings findings;
};

// A picture that is called rectified ("image_rect") is a pinhole's with P; any other is one's with
// K, through the lens of D. The baseline is P's; where P has none the two frames are looked up in
// /tf_static. Errors name bag, topic and field, and what to give.
absl::StatusOr<CameraInfoRig> MakeCameraInfoRig(const std::string& bag, const RigChoice& choice,
                                                const TransformTree& tree,
                                                const BagOptions& options);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_CAMERA_INFO_RIG_H_
