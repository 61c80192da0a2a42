#include "client_agent/source/calibration/yaml_numbers.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client_agent/source/calibration/yaml_fields.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr int kMaxSide_px = 16384;
// A camera that seems farther from its body is given in millimetres.
constexpr double kMaxLever_m = 20;

bool AppendNumbers(const YAML::Node& list, std::vector<double>& numbers) {
  for (const YAML::Node& entry : list) {
    if (entry.IsSequence()) {
      if (!AppendNumbers(entry, numbers)) return false;
    } else if (!ReadFinite(entry, numbers.emplace_back())) {
      return false;
    }
  }
  return true;
}

// Returns whether a motion is of a camera on its robot; others are from camera to camera.
bool IsOfBody(absl::string_view field) {
  constexpr absl::string_view kOfBody[] = {"T_BS", "body", "imu", "Tbc", "T_b_c"};
  return std::any_of(std::begin(kOfBody), std::end(kOfBody),
                     [&](absl::string_view part) { return absl::StrContains(field, part); });
}

absl::Status NoMotion(const std::string& path, absl::string_view field, absl::string_view why) {
  return absl::InvalidArgumentError(absl::StrCat(path, ": ", field, " is no motion: ", why));
}

}  // namespace

absl::StatusOr<std::vector<double>> ReadNumbers(const YAML::Node& list, const std::string& path,
                                                absl::string_view field, size_t least,
                                                size_t most) {
  const std::string wanted =
      least == most ? absl::StrCat(least) : absl::StrCat(least, " to ", most);
  const absl::Status error = absl::InvalidArgumentError(
      absl::StrCat(path, ": ", field, " is no list of ", wanted, " finite numbers"));
  std::vector<double> numbers;
  if (!list.IsDefined() || !list.IsSequence() || !AppendNumbers(list, numbers)) return error;
  if (numbers.size() < least || numbers.size() > most) return error;
  return numbers;
}

absl::StatusOr<double> ReadNumber(const YAML::Node& node, const std::string& path,
                                  absl::string_view field) {
  double number = 0;
  if (ReadFinite(node, number)) return number;
  return absl::InvalidArgumentError(absl::StrCat(path, ": ", field, " is no finite number"));
}

absl::StatusOr<PictureSize> ReadSize(const YAML::Node& list, const std::string& path,
                                     absl::string_view field) {
  ASSIGN_OR_RETURN(const std::vector<double> size, ReadNumbers(list, path, field, 2, 2));
  return ToSize(size[0], size[1], path, field);
}

absl::StatusOr<PictureSize> ToSize(double width_px, double height_px, const std::string& path,
                                   absl::string_view field) {
  for (const double side_px : {width_px, height_px}) {
    if (side_px >= 1 && side_px <= kMaxSide_px && side_px == std::floor(side_px)) continue;
    return absl::InvalidArgumentError(absl::StrCat(path, ": a side of the ", field, " is ", side_px,
                                                   ", must be a whole number in [1, ", kMaxSide_px,
                                                   "]"));
  }
  return PictureSize{static_cast<int>(width_px), static_cast<int>(height_px)};
}

absl::StatusOr<Rigid3d> ToRigid(const std::vector<double>& m, const std::string& path,
                                absl::string_view field) {
  if (m.size() != 16) return NoMotion(path, field, absl::StrCat(m.size(), " numbers, not 16"));
  Eigen::Matrix3d rotation;
  rotation << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
  const double error = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (!(error <= 0.01) || rotation.determinant() < 0) {
    return NoMotion(path, field, "its first three columns hold no rotation");
  }
  if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1) {
    return NoMotion(path, field,
                    absl::StrCat("its last row is ", m[12], " ", m[13], " ", m[14], " ", m[15],
                                 " instead of 0 0 0 1"));
  }
  const Eigen::Vector3d translation(m[3], m[7], m[11]);
  if (!(translation.norm() <= kMaxLever_m)) {
    return NoMotion(path, field,
                    IsOfBody(field) ? absl::StrCat("the camera is ", translation.norm(),
                                                   " m from the body: is it in metres?")
                                    : absl::StrCat("the cameras are ", translation.norm(),
                                                   " m apart: is it in metres?"));
  }
  return Rigid3d{Eigen::Quaterniond(rotation).normalized(), translation};
}

}  // namespace corbslam::client_agent
