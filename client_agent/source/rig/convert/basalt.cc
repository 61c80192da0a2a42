// Basalt's calibration (JSON, which YAML is a kind of): value0 with T_imu_cam, intrinsics and
// resolution, a list each with an entry for each camera.
#include <algorithm>
#include <cmath>
#include <optional>

#include "absl/strings/str_cat.h"
#include "client_agent/source/calibration/imu_noise_fields.h"
#include "client_agent/source/calibration/lens_names.h"
#include "client_agent/source/calibration/yaml_fields.h"
#include "client_agent/source/rig/convert/rig_readers.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

struct Model {
  absl::string_view name;
  absl::string_view lens;
  std::vector<const char*> numbers;
};

const std::vector<Model>& Models() {
  static const auto& models = *new std::vector<Model>{
      {"pinhole", "none", {}},
      {"ds", "double-sphere", {"xi", "alpha"}},
      {"kb4", "equidistant", {"k1", "k2", "k3", "k4"}},
      {"pinhole-radtan8", "radial-tangential", {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"}}};
  return models;
}

absl::Status Bad(const std::string& path, absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat(path, ": ", what));
}

absl::StatusOr<std::vector<double>> ReadNamed(const YAML::Node& node,
                                              const std::vector<const char*>& names,
                                              const std::string& path, const std::string& field) {
  std::vector<double> numbers;
  for (const char* name : names) {
    const YAML::Node number = node[name];
    if (!number.IsDefined()) return Bad(path, absl::StrCat(field, ".", name, " is missing"));
    ASSIGN_OR_RETURN(numbers.emplace_back(),
                     ReadNumber(number, path, absl::StrCat(field, ".", name)));
  }
  return numbers;
}

absl::StatusOr<RigCamera> ReadCamera(const YAML::Node& value, size_t index,
                                     const std::string& path) {
  const std::string field = absl::StrCat("value0.intrinsics[", index, "]");
  const YAML::Node camera = value["intrinsics"][index];
  const YAML::Node type = camera["camera_type"];
  const std::string word = type.IsDefined() && type.IsScalar() ? type.Scalar() : "";
  for (const Model& model : Models()) {
    if (model.name != word) continue;
    const YAML::Node intrinsics = camera["intrinsics"];
    const std::string within = field + ".intrinsics";
    ASSIGN_OR_RETURN(const auto k, ReadNamed(intrinsics, {"fx", "fy", "cx", "cy"}, path, within));
    ASSIGN_OR_RETURN(const auto numbers, ReadNamed(intrinsics, model.numbers, path, within));
    ASSIGN_OR_RETURN(const LensModel lens, LensOfName(model.lens, numbers));
    ASSIGN_OR_RETURN(
        const PictureSize size,
        ReadSize(value["resolution"][index], path, absl::StrCat("value0.resolution[", index, "]")));
    return RigCamera{{k[0], k[1], k[2], k[3], lens}, size.width_px, size.height_px};
  }
  return Bad(path, absl::StrCat(field, ".camera_type is '", word,
                                "', known are pinhole, ds, kb4 and pinhole-radtan8: calibrate "
                                "with one of these (basalt_calibrate --cam-types ds ds)"));
}

absl::StatusOr<Rigid3d> ReadImuFromCamera(const YAML::Node& value, size_t index,
                                          const std::string& path) {
  const std::string field = absl::StrCat("value0.T_imu_cam[", index, "]");
  ASSIGN_OR_RETURN(const auto n,
                   ReadNamed(value["T_imu_cam"][index], {"px", "py", "pz", "qx", "qy", "qz", "qw"},
                             path, field));
  const Eigen::Quaterniond rotation(n[6], n[3], n[4], n[5]);
  if (!(std::abs(rotation.norm() - 1) < 1e-3)) {
    return Bad(path, absl::StrCat(field, ": qx, qy, qz, qw have a length of ", rotation.norm(),
                                  ", must be 1"));
  }
  return Rigid3d{rotation.normalized(), Eigen::Vector3d(n[0], n[1], n[2])};
}

// Reads a number, or three of the axes, of which the largest is taken.
absl::StatusOr<std::optional<double>> ReadAxes(const YAML::Node& value, const char* name,
                                               const std::string& path) {
  const YAML::Node node = value[name];
  if (!node.IsDefined() || node.IsScalar()) return ReadIfThere(value, path, name);
  ASSIGN_OR_RETURN(const auto axes, ReadNumbers(node, path, absl::StrCat("value0.", name), 3, 3));
  return *std::max_element(axes.begin(), axes.end());
}

absl::Status ReadImu(const YAML::Node& value, const Rigid3d& imu_from_left, const std::string& path,
                     ConvertedRig& converted) {
  // Without an IMU its frame is the first camera's.
  const bool has_imu = value["imu_update_rate"].IsDefined() ||
                       value["gyro_noise_std"].IsDefined() || value["accel_noise_std"].IsDefined();
  if (!has_imu) return absl::OkStatus();
  StatedImu& imu = converted.rig.imu.emplace();
  imu.imu_from_camera = imu_from_left;
  ASSIGN_OR_RETURN(imu.rate_hz, ReadIfThere(value, path, "imu_update_rate"));
  ASSIGN_OR_RETURN(imu.gyro_noise, ReadAxes(value, "gyro_noise_std", path));
  ASSIGN_OR_RETURN(imu.accel_noise, ReadAxes(value, "accel_noise_std", path));
  ASSIGN_OR_RETURN(imu.gyro_walk, ReadAxes(value, "gyro_bias_std", path));
  ASSIGN_OR_RETURN(imu.accel_walk, ReadAxes(value, "accel_bias_std", path));
  // What is added to the camera's stamps to get the IMU's clock.
  ASSIGN_OR_RETURN(const auto offset_ns, ReadIfThere(value, path, "cam_time_offset_ns"));
  imu.time_offset_s = -1e-9 * offset_ns.value_or(0);
  for (const char* name : {"calib_accel_bias", "calib_gyro_bias"}) {
    if (!value[name].IsDefined()) continue;
    ASSIGN_OR_RETURN(const auto bias,
                     ReadNumbers(value[name], path, absl::StrCat("value0.", name), 1, 12));
    if (std::all_of(bias.begin(), bias.end(), [](double number) { return number == 0; })) continue;
    converted.notes.push_back(absl::StrCat("value0.", name,
                                           " is left out: a rig has no place for an IMU's scale "
                                           "and misalignment, and its bias is estimated"));
  }
  return absl::OkStatus();
}

absl::Status Read(const YAML::Node& file, const std::string& path, ConvertedRig& converted) {
  const YAML::Node value = file["value0"];
  for (const char* field : {"intrinsics", "resolution", "T_imu_cam"}) {
    if (value.IsMap() && value[field].IsSequence() && value[field].size() >= 2) continue;
    return Bad(path, absl::StrCat("value0.", field,
                                  " is no list of two cameras: a stereo pair has a left and a "
                                  "right one; with one camera the map has no scale"));
  }
  if (value["intrinsics"].size() > 2) {
    converted.notes.emplace_back("cameras after the first two are left out: a rig has two cameras");
  }
  Rig& rig = converted.rig;
  for (const size_t index : {0U, 1U}) {
    ASSIGN_OR_RETURN(rig.cameras.emplace_back(), ReadCamera(value, index, path));
  }
  ASSIGN_OR_RETURN(const Rigid3d imu_from_left, ReadImuFromCamera(value, 0, path));
  ASSIGN_OR_RETURN(const Rigid3d imu_from_right, ReadImuFromCamera(value, 1, path));
  rig.right_from_left = imu_from_right.Inverse() * imu_from_left;
  rig.body_from_camera = imu_from_left;
  return ReadImu(value, imu_from_left, path, converted);
}

}  // namespace

absl::StatusOr<ConvertedRig> ReadBasalt(const RigFiles& files) {
  return ReadOneFile(files, "Basalt's calibration.json", &Read);
}

}  // namespace corbslam::client_agent
