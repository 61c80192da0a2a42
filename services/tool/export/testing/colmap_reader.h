// Reads COLMAP's text model without knowing who wrote it; tests check exports by it.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_TESTING_COLMAP_READER_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_TESTING_COLMAP_READER_H_

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/geometry/rigid3.h"

namespace corbslam::testing {

struct ColmapCamera {
  int width_px = 0;
  int height_px = 0;
  double fx_px = 0;
  double fy_px = 0;
  double cx_px = 0;
  double cy_px = 0;
  // Empty for PINHOLE, k1 k2 p1 p2 for OPENCV, k1 k2 p1 p2 k3 k4 k5 k6 for FULL_OPENCV.
  std::vector<double> distortion;
};
struct ColmapImage {
  Rigid3d camera_from_world;
  int64_t camera = 0;
  std::string name;
  // The position, and the point's number or -1.
  std::vector<std::pair<Eigen::Vector2d, int64_t>> keypoints;
};
struct ColmapPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3i rgb = Eigen::Vector3i::Zero();
  double error_px = 0;
  std::vector<std::pair<int64_t, size_t>> track;  // The image, and the index of its keypoint.
};
struct ColmapModel {
  std::map<int64_t, ColmapCamera> cameras;
  std::map<int64_t, ColmapImage> images;
  std::map<int64_t, ColmapPoint> points;
};

// Returns INVALID_ARGUMENT for a line of another form, and where a track and an image contradict
// each other, or name what is not there.
absl::StatusOr<ColmapModel> ReadColmapModel(const std::string& folder);

// Returns the distances between points' projections and the keypoints that see them, ascending;
// infinite for a point behind its camera.
std::vector<double> ReprojectionErrors_px(const ColmapModel& model);

}  // namespace corbslam::testing

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_TESTING_COLMAP_READER_H_
