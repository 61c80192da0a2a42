#include "client_agent/source/calibration/euroc_calibration.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client_agent/source/calibration/yaml_fields.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr int kMaxSide_px = 16384;
// A camera that seems farther from its body is given in millimetres.
constexpr double kMaxLever_m = 20;

absl::StatusOr<std::vector<double>> ReadNumbers(const YAML::Node& list, const std::string& path,
                                                absl::string_view field, size_t least,
                                                size_t most) {
  const absl::Status error = absl::InvalidArgumentError(
      absl::StrCat(path, ": ", field, " is no list of ", least, " finite numbers"));
  if (!list.IsDefined() || !list.IsSequence()) return error;
  if (list.size() < least || list.size() > most) return error;
  std::vector<double> numbers;
  for (const YAML::Node& entry : list) {
    if (!ReadFinite(entry, numbers.emplace_back())) return error;
  }
  return numbers;
}

absl::Status NoMotion(const std::string& path, absl::string_view why) {
  return absl::InvalidArgumentError(absl::StrCat(path, ": T_BS is no motion: ", why));
}

absl::StatusOr<Rigid3d> ToRigid(const std::vector<double>& m, const std::string& path) {
  Eigen::Matrix3d rotation;
  rotation << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
  const double error = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (!(error <= 0.01) || rotation.determinant() < 0) {
    return NoMotion(path, "its first three columns hold no rotation");
  }
  if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1) {
    return NoMotion(path, absl::StrCat("its last row is ", m[12], " ", m[13], " ", m[14], " ",
                                       m[15], " instead of 0 0 0 1"));
  }
  const Eigen::Vector3d translation(m[3], m[7], m[11]);
  if (!(translation.norm() <= kMaxLever_m)) {
    return NoMotion(path, absl::StrCat("the camera is ", translation.norm(),
                                       " m from the body: is it in metres?"));
  }
  return Rigid3d{Eigen::Quaterniond(rotation).normalized(), translation};
}

absl::Status ExpectWord(const YAML::Node& file, const std::string& path, const char* field,
                        const std::vector<std::string>& expected) {
  const YAML::Node node = file[field];
  const std::string word = node.IsDefined() && node.IsScalar() ? node.Scalar() : "";
  if (std::find(expected.begin(), expected.end(), word) != expected.end()) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(path, ": ", field, " is '", word, "', only ",
                                                 absl::StrJoin(expected, ", "), " is known"));
}

// Reads k1 k2 p1 p2 [k3 [k4 k5 k6]], as OpenCV orders them. The last three are of another model.
absl::StatusOr<RadialTangential> ReadDistortion(const YAML::Node& file, const std::string& path) {
  const char* field = "distortion_coefficients";
  ASSIGN_OR_RETURN(std::vector<double> d, ReadNumbers(file[field], path, field, 4, 8));
  d.resize(8, 0.0);
  if (d[5] != 0 || d[6] != 0 || d[7] != 0) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": ", field, " has k4 k5 k6 (", d[5], ", ", d[6], ", ", d[7],
                     "), the rational model, which is not known: calibrate with 4 or 5 "
                     "coefficients"));
  }
  return RadialTangential{d[0], d[1], d[2], d[3], d[4]};
}

absl::StatusOr<EurocCamera> Parse(const YAML::Node& file, const std::string& path) {
  RETURN_IF_ERROR(ExpectWord(file, path, "camera_model", {"pinhole"}));
  RETURN_IF_ERROR(ExpectWord(file, path, "distortion_model", {"radial-tangential", "radtan"}));
  ASSIGN_OR_RETURN(const std::vector<double> pose,
                   ReadNumbers(file["T_BS"]["data"], path, "T_BS data", 16, 16));
  ASSIGN_OR_RETURN(const std::vector<double> size,
                   ReadNumbers(file["resolution"], path, "resolution", 2, 2));
  ASSIGN_OR_RETURN(const std::vector<double> f,
                   ReadNumbers(file["intrinsics"], path, "intrinsics", 4, 4));
  for (const double side_px : size) {
    if (side_px >= 1 && side_px <= kMaxSide_px) continue;
    return absl::InvalidArgumentError(absl::StrCat(path, ": a side of the resolution is ", side_px,
                                                   ", must be in [1, ", kMaxSide_px, "]"));
  }
  EurocCamera camera;
  ASSIGN_OR_RETURN(camera.body_from_camera, ToRigid(pose, path));
  ASSIGN_OR_RETURN(const RadialTangential distortion, ReadDistortion(file, path));
  camera.width_px = static_cast<int>(size[0]);
  camera.height_px = static_cast<int>(size[1]);
  camera.intrinsics = {f[0], f[1], f[2], f[3], distortion};
  return camera;
}

}  // namespace

absl::StatusOr<EurocCamera> ReadEurocCamera(const std::string& sensor_yaml_path) {
  EurocCamera camera;
  RETURN_IF_ERROR(UseYamlFields(sensor_yaml_path, [&](const YAML::Node& file) -> absl::Status {
    ASSIGN_OR_RETURN(camera, Parse(file, sensor_yaml_path));
    return absl::OkStatus();
  }));
  return camera;
}

std::string EurocRoot(const std::string& directory) {
  std::error_code ignored;
  const std::string mav0 = directory + "/mav0";
  return std::filesystem::is_directory(mav0, ignored) ? mav0 : directory;
}

}  // namespace corbslam::client_agent
