#include "client_agent/live/ros2/ros2_rig.h"

#include <glog/logging.h>

#include <utility>

#include "client_agent/source/bag/bag_contents.h"
#include "client_agent/source/bag/camera_info_rig.h"
#include "client_agent/source/bag/topic_names.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {

bool IsRegistered(const Ros2Settings& settings, const Ros2Side (&sides)[2],
                  std::optional<bool> registers) {
  if (registers.has_value()) return !*registers;
  return SaysRegistered(settings.images[1].topic) || sides[0].frame_id == sides[1].frame_id;
}

absl::StatusOr<Rig> MakeRos2Rig(const Ros2Settings& settings, const Ros2Side (&sides)[2],
                                const TransformTree& tree, std::optional<bool> registers,
                                bool trust_calibration) {
  BagTopic topics[2];
  RigChoice choice;
  choice.kind = settings.is_rgbd ? RigKind::kRgbd : RigKind::kStereo;
  choice.is_registered = settings.is_rgbd && IsRegistered(settings, sides, registers);
  PictureTopic* const pictures[2] = {&choice.first, &choice.second};
  for (size_t side = 0; side < 2; ++side) {
    topics[side].name = settings.images[side].topic;
    PictureTopic& picture = *pictures[side];
    picture.topic = &topics[side];
    picture.base = BaseTopic(topics[side].name);
    picture.form = *sides[side].form;
    picture.frame_id = sides[side].frame_id;
    picture.is_depth = side == 1 && settings.is_rgbd;
    picture.info = sides[side].info;
    picture.info_topic = settings.infos[side].topic;
  }
  BagOptions options;
  options.registers = registers;
  options.trust_calibration = trust_calibration;
  ASSIGN_OR_RETURN(CameraInfoRig made, MakeCameraInfoRig("ros2", choice, tree, options));
  ASSIGN_OR_RETURN(const SourceFindings judged, JudgeRig(made.rig, made.from, trust_calibration));
  made.findings.insert(made.findings.end(), judged.begin(), judged.end());
  for (const SourceFinding& finding : made.findings) {
    LOG(WARNING) << finding.text << " [" << finding.code << "]";
  }
  LOG(INFO) << "the cameras are those of " << made.from;
  return std::move(made.rig);
}

}  // namespace corbslam::client_agent
