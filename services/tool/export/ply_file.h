// Writes coloured points as PLY: binary, little-endian, float x, y, z and uchar red, green, blue.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_PLY_FILE_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_PLY_FILE_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "services/tool/export/robot_colours.h"

namespace corbslam::services {

struct ColouredPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Colour colour;
};

// `comments` stand in the header, a line each. Errors are WriteAtomically's.
absl::Status WritePly(const std::vector<ColouredPoint>& points,
                      const std::vector<std::string>& comments, const std::string& path);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_PLY_FILE_H_
