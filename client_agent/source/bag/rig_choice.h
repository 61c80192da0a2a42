// Chooses which two topics of a bag are a stereo pair or an RGB-D camera.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_RIG_CHOICE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_RIG_CHOICE_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/source/bag/bag_options.h"
#include "client_agent/source/bag/messages/transforms.h"
#include "client_agent/source/bag/picture_topic.h"
#include "client_agent/source/rig/rig.h"

namespace corbslam::client_agent {

struct RigChoice {
  RigKind kind = RigKind::kStereo;
  PictureTopic first;   // Left, or the RGB-D camera's picture.
  PictureTopic second;  // Right, or depth.
  // Depth is said to be registered to the picture.
  bool is_registered = false;
  // What else could be played, as options: "left=/a&right=/b".
  std::vector<std::string> others;
};

// Chooses by the options; what they leave open, by what has a calibration, by names and by frames.
// `kind` of a rig file that is given narrows it down. NOT_FOUND lists the bag's pictures and says
// what to give.
absl::StatusOr<RigChoice> ChooseRig(const std::string& bag,
                                    const std::vector<PictureTopic>& pictures,
                                    const TransformTree& tree, const BagOptions& options,
                                    std::optional<RigKind> kind);

// Returns P's baseline from left to right, metres, with its sign; nullopt where the two CameraInfo
// say none.
std::optional<double> BaselineOfP(const PictureTopic& left, const PictureTopic& right);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_RIG_CHOICE_H_
