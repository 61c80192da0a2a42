// Converts values to Foxglove's messages.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_FOXGLOVE_VALUES_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_FOXGLOVE_VALUES_H_

#include <google/protobuf/timestamp.pb.h>

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "foxglove/frames.pb.h"
#include "foxglove/geometry.pb.h"
#include "services/tool/export/robot_colours.h"
#include "slam/geometry/rigid3.h"

namespace corbslam::services {

void ToFoxglove(uint64_t time_ns, google::protobuf::Timestamp* message);
void ToFoxglove(const Eigen::Vector3d& position, foxglove::Vector3* message);
void ToFoxglove(const Eigen::Vector3d& position, foxglove::Point3* message);
void ToFoxglove(const Eigen::Quaterniond& rotation, foxglove::Quaternion* message);
void ToFoxglove(const Rigid3d& frame_from_object, foxglove::Pose* message);
void ToFoxglove(const Colour& colour, double opacity, foxglove::Color* message);

void SetTransform(uint64_t time_ns, const std::string& parent, const std::string& child,
                  const Rigid3d& parent_from_child, foxglove::FrameTransform* message);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_FOXGLOVE_VALUES_H_
