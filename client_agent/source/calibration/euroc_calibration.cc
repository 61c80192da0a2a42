#include "client_agent/source/calibration/euroc_calibration.h"

#include <algorithm>
#include <filesystem>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client_agent/source/calibration/imu_noise_fields.h"
#include "client_agent/source/calibration/lens_names.h"
#include "client_agent/source/calibration/yaml_fields.h"
#include "client_agent/source/calibration/yaml_numbers.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

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

absl::StatusOr<LensModel> ReadLens(const YAML::Node& file, const std::string& path) {
  RETURN_IF_ERROR(
      ExpectWord(file, path, "distortion_model", {"radial-tangential", "radtan", "equidistant"}));
  const char* field = "distortion_coefficients";
  ASSIGN_OR_RETURN(const std::vector<double> numbers, ReadNumbers(file[field], path, field, 4, 8));
  auto lens = LensOfName(file["distortion_model"].Scalar(), numbers);
  if (lens.ok()) return lens;
  return absl::InvalidArgumentError(absl::StrCat(path, ": ", field, ": ", lens.status().message()));
}

absl::StatusOr<EurocCamera> Parse(const YAML::Node& file, const std::string& path) {
  RETURN_IF_ERROR(ExpectWord(file, path, "camera_model", {"pinhole"}));
  ASSIGN_OR_RETURN(const std::vector<double> pose,
                   ReadNumbers(file["T_BS"]["data"], path, "T_BS data", 16, 16));
  ASSIGN_OR_RETURN(const PictureSize size, ReadSize(file["resolution"], path, "resolution"));
  ASSIGN_OR_RETURN(const std::vector<double> f,
                   ReadNumbers(file["intrinsics"], path, "intrinsics", 4, 4));
  EurocCamera camera;
  ASSIGN_OR_RETURN(camera.body_from_camera, ToRigid(pose, path, "T_BS"));
  ASSIGN_OR_RETURN(LensModel lens, ReadLens(file, path));
  camera.width_px = size.width_px;
  camera.height_px = size.height_px;
  camera.intrinsics = {f[0], f[1], f[2], f[3], std::move(lens)};
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

absl::StatusOr<EurocImu> ReadEurocImu(const std::string& sensor_yaml_path) {
  EurocImu imu;
  const std::string& path = sensor_yaml_path;
  RETURN_IF_ERROR(UseYamlFields(path, [&](const YAML::Node& file) -> absl::Status {
    if (file["sensor_type"].IsDefined()) {
      RETURN_IF_ERROR(ExpectWord(file, path, "sensor_type", {"imu"}));
    }
    const YAML::Node matrix = file["T_BS"];
    if (!matrix.IsDefined()) {
      return absl::InvalidArgumentError(
          absl::StrCat(path, ": T_BS is missing: where the IMU sits"));
    }
    ASSIGN_OR_RETURN(const std::vector<double> pose,
                     ReadNumbers(matrix.IsMap() ? matrix["data"] : matrix, path, "T_BS", 16, 16));
    ASSIGN_OR_RETURN(imu.body_from_imu, ToRigid(pose, path, "T_BS"));
    ASSIGN_OR_RETURN(imu.stated.rate_hz, ReadIfThere(file, path, "rate_hz"));
    return ReadKalibrNoise(file, path, imu.stated);
  }));
  const absl::Status possible = Validate(imu.stated);
  if (possible.ok()) return imu;
  return absl::InvalidArgumentError(absl::StrCat(path, ": ", possible.message()));
}

std::string EurocRoot(const std::string& directory) {
  std::error_code ignored;
  const std::string mav0 = directory + "/mav0";
  return std::filesystem::is_directory(mav0, ignored) ? mav0 : directory;
}

}  // namespace corbslam::client_agent
