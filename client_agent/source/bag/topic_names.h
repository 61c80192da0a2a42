// What the names of topics say, as camera drivers choose them.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_TOPIC_NAMES_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_TOPIC_NAMES_H_

#include <cstddef>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"

namespace corbslam::client_agent {

// Returns the name without what image_transport puts behind: "/compressed", "/compressedDepth".
std::string BaseTopic(absl::string_view topic);
// Returns where the CameraInfo of a picture may be, the most probable first: "/a/camera_info" of
// "/a/image_raw".
std::vector<std::string> CameraInfoTopics(absl::string_view base);
// Returns whether one name is the other with "left" for "right", "cam0" for "cam1" and the like.
bool AreLeftAndRight(absl::string_view left, absl::string_view right);
// Returns whether a picture is called rectified.
bool SaysRectified(absl::string_view base);
// Returns whether depth is said to be registered to the other picture: "aligned_depth_to_color".
bool SaysRegistered(absl::string_view base);
// Returns whether a picture of 16 bits or floats is called something else than depth.
bool SaysNoDepth(absl::string_view base);
bool SaysDepth(absl::string_view base);
// Returns how many parts between slashes both names begin with.
size_t CommonParts(absl::string_view a, absl::string_view b);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_TOPIC_NAMES_H_
