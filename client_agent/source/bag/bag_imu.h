// Finds the IMU of a bag: what it measured, and where it sits.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_IMU_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_IMU_H_

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "client_agent/source/bag/bag_contents.h"
#include "client_agent/source/bag/bag_options.h"
#include "client_agent/source/bag/messages/transforms.h"
#include "client_agent/source/calibration/stated_imu.h"
#include "client_agent/source/source_finding.h"
#include "slam/inertial/imu.h"

namespace corbslam::client_agent {

struct BagImu {
  StatedImu stated;
  ImuSamples samples;  // In the order of time, stamped by its own clock.
  std::string from;    // Bag and topic, for messages.
};

struct BagImuQuery {
  const BagOptions& options;
  const TransformTree& tree;
  const std::optional<StatedImu>& of_rig;  // A rig file's word goes before /tf_static's.
  std::string camera_frame_id;             // Of the first camera.
  bool by_recording_time = false;
  bool has_drives = false;  // The time of its frames jumps back.
};

// Takes the topic that ?imu=TOPIC names, or the only one there is. Nullopt, which `remarks` tell
// where there is an IMU: several topics and none named, or nobody says where it sits.
// INVALID_ARGUMENT: the named topic holds nothing of an IMU, or nobody says where that sits; and as
// PutInOrder.
absl::StatusOr<std::optional<BagImu>> FindBagImu(const BagContents& contents,
                                                 const BagImuQuery& query, SourceRemarks& remarks);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_IMU_H_
