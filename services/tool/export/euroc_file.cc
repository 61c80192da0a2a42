#include "services/tool/export/euroc_file.h"

#include <vector>

#include "absl/strings/str_format.h"
#include "slam/util/text_file.h"

namespace corbslam::services {

absl::Status WriteEurocTrajectory(const Trajectory& trajectory, const std::string& path) {
  std::vector<std::string> lines = {
      "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],"
      "q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []"};
  for (const StampedPose& pose : trajectory) {
    const Eigen::Vector3d& t = pose.world_from_camera.translation;
    const Eigen::Quaterniond& q = pose.world_from_camera.rotation;
    lines.push_back(absl::StrFormat("%d,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f", pose.timestamp_ns,
                                    t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z()));
  }
  return WriteLines(lines, path);
}

}  // namespace corbslam::services
