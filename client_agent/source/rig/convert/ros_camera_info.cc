#include <Eigen/Core>

#include "absl/strings/str_cat.h"
#include "client_agent/source/calibration/lens_words.h"
#include "client_agent/source/calibration/yaml_fields.h"
#include "client_agent/source/rig/convert/rig_readers.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

struct CameraInfo {
  RigCamera camera;
  Eigen::Matrix3d rectified_from_camera;
  double shift_px_m = 0;  // P's fourth column: -fx times the baseline.
  double rectified_fx_px = 0;
};

absl::StatusOr<std::vector<double>> ReadMatrix(const YAML::Node& file, const std::string& path,
                                               const char* field, size_t count) {
  const std::string data = absl::StrCat(field, ".data");
  const YAML::Node matrix = file[field];
  if (!matrix.IsDefined() || !matrix.IsMap()) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": ", field, " is missing"));
  }
  return ReadNumbers(matrix["data"], path, data, count, count);
}

absl::StatusOr<LensModel> ReadLens(const YAML::Node& file, const std::string& path) {
  const YAML::Node coefficients = file["distortion_coefficients"];
  if (!coefficients.IsDefined() || !coefficients.IsMap()) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": distortion_coefficients is missing"));
  }
  ASSIGN_OR_RETURN(const std::vector<double> numbers,
                   ReadNumbers(coefficients["data"], path, "distortion_coefficients.data", 0, 14));
  const YAML::Node word = file["distortion_model"];
  const auto lens = LensOfWords(word.IsDefined() && word.IsScalar() ? word.Scalar() : "", numbers);
  if (lens.ok()) return lens;
  return absl::InvalidArgumentError(
      absl::StrCat(path, ": distortion_model: ", lens.status().message()));
}

absl::Status Read(const YAML::Node& file, const std::string& path, CameraInfo& info) {
  ASSIGN_OR_RETURN(const double width_px, ReadNumber(file["image_width"], path, "image_width"));
  ASSIGN_OR_RETURN(const double height_px, ReadNumber(file["image_height"], path, "image_height"));
  ASSIGN_OR_RETURN(const auto k, ReadMatrix(file, path, "camera_matrix", 9));
  ASSIGN_OR_RETURN(const auto r, ReadMatrix(file, path, "rectification_matrix", 9));
  ASSIGN_OR_RETURN(const auto p, ReadMatrix(file, path, "projection_matrix", 12));
  ASSIGN_OR_RETURN(info.camera.raw.lens, ReadLens(file, path));
  info.camera.raw.fx_px = k[0];
  info.camera.raw.fy_px = k[4];
  info.camera.raw.cx_px = k[2];
  info.camera.raw.cy_px = k[5];
  info.camera.width_px = static_cast<int>(width_px);
  info.camera.height_px = static_cast<int>(height_px);
  info.rectified_from_camera << r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8];
  info.rectified_fx_px = p[0];
  info.shift_px_m = p[3];
  const Eigen::Matrix3d error =
      info.rectified_from_camera * info.rectified_from_camera.transpose() -
      Eigen::Matrix3d::Identity();
  if (error.norm() < 0.01) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(path, ": rectification_matrix.data holds no rotation"));
}

}  // namespace

Rigid3d MotionOfRectified(const Eigen::Matrix3d& left_rotation,
                          const Eigen::Matrix3d& right_rotation, double baseline_m) {
  // A point of the rectified left frame has x less by the baseline in the rectified right one.
  Rigid3d motion;
  motion.rotation =
      Eigen::Quaterniond(Eigen::Matrix3d(right_rotation.transpose() * left_rotation)).normalized();
  motion.translation = right_rotation.transpose() * Eigen::Vector3d(-baseline_m, 0, 0);
  return motion;
}

absl::StatusOr<ConvertedRig> ReadRosPair(const RigFiles& files) {
  RETURN_IF_ERROR(ExpectFiles(files, 2, "the camera_info of the left and of the right camera"));
  CameraInfo infos[2];
  for (size_t i = 0; i < 2; ++i) {
    const std::string& path = files.paths[i];
    RETURN_IF_ERROR(
        UseYamlFields(path, [&](const YAML::Node& file) { return Read(file, path, infos[i]); }));
  }
  const auto& [left, right] = infos;
  if (left.shift_px_m != 0 || !(right.shift_px_m < 0)) {
    return absl::InvalidArgumentError(
        absl::StrCat("projection_matrix has ", left.shift_px_m, " in its fourth column in ",
                     files.paths[0], " and ", right.shift_px_m, " in ", files.paths[1],
                     "; a pair that was calibrated as one has 0 in the left and a negative number "
                     "(-fx times the "
                     "baseline) in the right one: are they exchanged, or calibrated one by one?"));
  }
  ConvertedRig converted;
  Rig& rig = converted.rig;
  rig.cameras = {left.camera, right.camera};
  rig.right_from_left = MotionOfRectified(left.rectified_from_camera, right.rectified_from_camera,
                                          -right.shift_px_m / right.rectified_fx_px);
  return converted;
}

}  // namespace corbslam::client_agent
