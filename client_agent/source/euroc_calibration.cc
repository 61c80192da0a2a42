#include "client_agent/source/euroc_calibration.h"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <exception>
#include <filesystem>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

constexpr int kMaxSide_px = 16384;

bool IsFiniteNumber(const YAML::Node& node, double& number) {
  return node.IsScalar() && absl::SimpleAtod(node.Scalar(), &number) && std::isfinite(number);
}

absl::StatusOr<std::vector<double>> ReadNumbers(const YAML::Node& list, const std::string& path,
                                                absl::string_view field, size_t least,
                                                size_t most) {
  const absl::Status error = absl::InvalidArgumentError(
      absl::StrCat(path, ": ", field, " is no list of ", least, " finite numbers"));
  if (!list.IsDefined() || !list.IsSequence()) return error;
  if (list.size() < least || list.size() > most) return error;
  std::vector<double> numbers;
  for (const YAML::Node& entry : list) {
    if (!IsFiniteNumber(entry, numbers.emplace_back())) return error;
  }
  return numbers;
}

absl::StatusOr<Rigid3d> ToRigid(const std::vector<double>& m, const std::string& path) {
  Eigen::Matrix3d rotation;
  rotation << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
  const double error = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (!(error <= 0.01) || rotation.determinant() < 0) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": T_BS holds no rotation"));
  }
  return Rigid3d{Eigen::Quaterniond(rotation).normalized(), Eigen::Vector3d(m[3], m[7], m[11])};
}

absl::Status ExpectWord(const YAML::Node& file, const std::string& path, const char* field,
                        absl::string_view expected) {
  const YAML::Node node = file[field];
  const std::string word = node.IsDefined() && node.IsScalar() ? node.Scalar() : "";
  if (word == expected) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(path, ": ", field, " is '", word, "', only ", expected, " is known"));
}

absl::StatusOr<EurocCamera> Parse(const YAML::Node& file, const std::string& path) {
  RETURN_IF_ERROR(ExpectWord(file, path, "camera_model", "pinhole"));
  RETURN_IF_ERROR(ExpectWord(file, path, "distortion_model", "radial-tangential"));
  ASSIGN_OR_RETURN(const std::vector<double> pose,
                   ReadNumbers(file["T_BS"]["data"], path, "T_BS data", 16, 16));
  ASSIGN_OR_RETURN(const std::vector<double> size,
                   ReadNumbers(file["resolution"], path, "resolution", 2, 2));
  ASSIGN_OR_RETURN(const std::vector<double> f,
                   ReadNumbers(file["intrinsics"], path, "intrinsics", 4, 4));
  ASSIGN_OR_RETURN(const std::vector<double> d, ReadNumbers(file["distortion_coefficients"], path,
                                                            "distortion_coefficients", 4, 5));
  for (const double side_px : size) {
    if (side_px >= 1 && side_px <= kMaxSide_px) continue;
    return absl::InvalidArgumentError(absl::StrCat(path, ": a side of the resolution is ", side_px,
                                                   ", must be in [1, ", kMaxSide_px, "]"));
  }
  EurocCamera camera;
  ASSIGN_OR_RETURN(camera.body_from_camera, ToRigid(pose, path));
  camera.width_px = static_cast<int>(size[0]);
  camera.height_px = static_cast<int>(size[1]);
  camera.intrinsics = {f[0], f[1], f[2], f[3], {d[0], d[1], d[2], d[3], d.size() > 4 ? d[4] : 0.0}};
  return camera;
}

}  // namespace

absl::StatusOr<EurocCamera> ReadEurocCamera(const std::string& sensor_yaml_path) {
  std::error_code ignored;
  if (!std::filesystem::exists(sensor_yaml_path, ignored)) {
    return absl::NotFoundError(absl::StrCat("cannot open ", sensor_yaml_path));
  }
  try {
    return Parse(YAML::LoadFile(sensor_yaml_path), sensor_yaml_path);
  } catch (const std::exception& exception) {
    // The parser's own (with line and column), and what it lets through of the standard library.
    return absl::InvalidArgumentError(absl::StrCat(sensor_yaml_path, ": ", exception.what()));
  }
}

std::string EurocRoot(const std::string& directory) {
  std::error_code ignored;
  const std::string mav0 = directory + "/mav0";
  return std::filesystem::is_directory(mav0, ignored) ? mav0 : directory;
}

}  // namespace corbslam
