#include <Eigen/Core>
#include <tuple>

#include "absl/strings/str_cat.h"
#include "client_agent/source/calibration/lens_names.h"
#include "client_agent/source/calibration/yaml_fields.h"
#include "client_agent/source/rig/convert/rig_readers.h"
#include "client_agent/source/rig/rectified_motion.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

struct CameraInfo {
  RigCamera camera;
  Eigen::Matrix3d rectified_from_camera;
  double shift_px_m = 0;  // P's fourth column: -fx times the baseline.
  double rectified_fx_px = 0;
};

// How the fields of a camera_info are called: in the files of camera_calibration, in what `rostopic
// echo` and what `ros2 topic echo` print.
struct Names {
  const char* width;
  const char* height;
  const char* k;
  const char* d;
  const char* r;
  const char* p;
};
constexpr Names kOfFiles = {"image_width",          "image_height",
                            "camera_matrix",        "distortion_coefficients",
                            "rectification_matrix", "projection_matrix"};
constexpr Names kOfMessages[] = {{"width", "height", "K", "D", "R", "P"},
                                 {"width", "height", "k", "d", "r", "p"}};

Names NamesIn(const YAML::Node& file) {
  for (const Names& names : kOfMessages) {
    if (file[names.k].IsDefined()) return names;
  }
  return kOfFiles;
}

// Files have a matrix as a map with `data`, messages as a list.
absl::StatusOr<std::vector<double>> ReadMatrix(const YAML::Node& file, const std::string& path,
                                               const std::string& field, size_t least,
                                               size_t most) {
  const YAML::Node matrix = file[field];
  if (!matrix.IsDefined() || !(matrix.IsMap() || matrix.IsSequence())) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": ", field, " is missing"));
  }
  if (matrix.IsSequence()) return ReadNumbers(matrix, path, field, least, most);
  return ReadNumbers(matrix["data"], path, field + ".data", least, most);
}

absl::StatusOr<LensModel> ReadLens(const YAML::Node& file, const std::string& path,
                                   const Names& names) {
  ASSIGN_OR_RETURN(const std::vector<double> numbers, ReadMatrix(file, path, names.d, 0, 14));
  const YAML::Node word = file["distortion_model"];
  const auto lens = LensOfName(word.IsDefined() && word.IsScalar() ? word.Scalar() : "", numbers);
  if (lens.ok()) return lens;
  return absl::InvalidArgumentError(
      absl::StrCat(path, ": distortion_model: ", lens.status().message()));
}

// A driver that bins pixels or cuts a part out sends pictures of another size than K is of.
absl::Status CheckWhole(const YAML::Node& file, const std::string& path) {
  const YAML::Node roi = file["roi"];
  const bool has_roi = roi.IsDefined() && roi.IsMap();
  for (const auto& [field, node, most] :
       {std::tuple("binning_x", file["binning_x"], 1),
        {"binning_y", file["binning_y"], 1},
        {"roi.x_offset", has_roi ? roi["x_offset"] : YAML::Node(), 0},
        {"roi.y_offset", has_roi ? roi["y_offset"] : YAML::Node(), 0}}) {
    double number = 0;
    if (!ReadFinite(node, number) || number <= most) continue;
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": ", field, " is ", number,
                     ": these pictures are not those that were calibrated; have the driver send "
                     "whole ones, or calibrate as it sends them"));
  }
  return absl::OkStatus();
}

absl::Status Read(const YAML::Node& file, const std::string& path, CameraInfo& info) {
  const Names names = NamesIn(file);
  ASSIGN_OR_RETURN(const double width_px, ReadNumber(file[names.width], path, names.width));
  ASSIGN_OR_RETURN(const double height_px, ReadNumber(file[names.height], path, names.height));
  ASSIGN_OR_RETURN(const PictureSize size, ToSize(width_px, height_px, path,
                                                  absl::StrCat(names.width, ", ", names.height)));
  ASSIGN_OR_RETURN(const auto k, ReadMatrix(file, path, names.k, 9, 9));
  ASSIGN_OR_RETURN(const auto r, ReadMatrix(file, path, names.r, 9, 9));
  ASSIGN_OR_RETURN(const auto p, ReadMatrix(file, path, names.p, 12, 12));
  RETURN_IF_ERROR(CheckCameraMatrix(k, path, names.k));
  RETURN_IF_ERROR(CheckWhole(file, path));
  ASSIGN_OR_RETURN(info.camera.raw.lens, ReadLens(file, path, names));
  info.camera.raw.fx_px = k[0];
  info.camera.raw.fy_px = k[4];
  info.camera.raw.cx_px = k[2];
  info.camera.raw.cy_px = k[5];
  info.camera.width_px = size.width_px;
  info.camera.height_px = size.height_px;
  info.rectified_from_camera << r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8];
  info.rectified_fx_px = p[0];
  info.shift_px_m = p[3];
  const Eigen::Matrix3d error =
      info.rectified_from_camera * info.rectified_from_camera.transpose() -
      Eigen::Matrix3d::Identity();
  if (!(info.rectified_fx_px > 0)) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": ", names.p, " has fx ", info.rectified_fx_px,
                     ", must be above 0: was this camera calibrated?"));
  }
  if (error.norm() < 0.01 && info.rectified_from_camera.determinant() > 0) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(path, ": ", names.r, " holds no rotation"));
}

}  // namespace

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
