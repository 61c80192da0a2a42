// Calibrations that list their cameras: SVO's (rpg_svo_pro) and OKVIS2's.
#include "absl/strings/str_cat.h"
#include "client_agent/source/calibration/imu_noise_fields.h"
#include "client_agent/source/calibration/lens_names.h"
#include "client_agent/source/calibration/yaml_fields.h"
#include "client_agent/source/rig/convert/rig_readers.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

absl::Status Bad(const std::string& path, absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat(path, ": ", what));
}

// A camera with its place on the body.
struct Listed {
  RigCamera camera;
  Rigid3d body_from_camera;
};
using ReadListed = absl::StatusOr<Listed> (*)(const YAML::Node& node, const std::string& path,
                                              const std::string& field);

std::string WordOf(const YAML::Node& node) {
  return node.IsDefined() && node.IsScalar() ? node.Scalar() : "";
}

// Reads a matrix as a list, or as {rows, cols, data}.
absl::StatusOr<std::vector<double>> ReadMatrix(const YAML::Node& node, const std::string& path,
                                               const std::string& field, size_t least,
                                               size_t most) {
  if (!node.IsDefined()) return Bad(path, absl::StrCat(field, " is missing"));
  return ReadNumbers(node.IsMap() ? node["data"] : node, path, field, least, most);
}

absl::StatusOr<LensModel> LensOf(const std::string& word, const std::vector<double>& numbers,
                                 const std::string& path, const std::string& field) {
  const auto lens = LensOfName(word, numbers);
  if (lens.ok()) return lens;
  return Bad(path, absl::StrCat(field, ": ", lens.status().message()));
}

// Returns the numbers of a lens, none where it is said not to distort.
absl::StatusOr<std::vector<double>> ReadLensNumbers(const YAML::Node& node, const std::string& path,
                                                    const std::string& field) {
  return ReadMatrix(node, path, field, 1, 14);
}

absl::StatusOr<Listed> ReadSvoCamera(const YAML::Node& entry, const std::string& path,
                                     const std::string& field) {
  const YAML::Node node = entry["camera"];
  const std::string type = WordOf(node["type"]);
  if (type != "pinhole") {
    return Bad(path, absl::StrCat(field, ".camera.type is '", type,
                                  "', known is pinhole: calibrate with Kalibr, whose camchain.yaml "
                                  "is read, too"));
  }
  Listed listed;
  ASSIGN_OR_RETURN(const auto k,
                   ReadMatrix(node["intrinsics"], path, field + ".camera.intrinsics", 4, 4));
  listed.camera.raw = {k[0], k[1], k[2], k[3], {}};
  if (const YAML::Node distortion = node["distortion"]; distortion.IsDefined()) {
    const std::string within = field + ".camera.distortion";
    const std::string word = WordOf(distortion["type"]);
    std::vector<double> numbers;
    if (word != "none") {
      ASSIGN_OR_RETURN(numbers,
                       ReadLensNumbers(distortion["parameters"], path, within + ".parameters"));
    }
    ASSIGN_OR_RETURN(listed.camera.raw.lens, LensOf(word, numbers, path, within));
  }
  ASSIGN_OR_RETURN(const double width,
                   ReadNumber(node["image_width"], path, field + ".image_width"));
  ASSIGN_OR_RETURN(const double height,
                   ReadNumber(node["image_height"], path, field + ".image_height"));
  ASSIGN_OR_RETURN(const PictureSize size, ToSize(width, height, path, field + ".image_width"));
  listed.camera.width_px = size.width_px;
  listed.camera.height_px = size.height_px;
  ASSIGN_OR_RETURN(const auto rows, ReadMatrix(entry["T_B_C"], path, field + ".T_B_C", 16, 16));
  ASSIGN_OR_RETURN(listed.body_from_camera, ToRigid(rows, path, field + ".T_B_C"));
  return listed;
}

absl::StatusOr<Listed> ReadOkvisCamera(const YAML::Node& node, const std::string& path,
                                       const std::string& field) {
  Listed listed;
  ASSIGN_OR_RETURN(const auto f,
                   ReadMatrix(node["focal_length"], path, field + ".focal_length", 2, 2));
  ASSIGN_OR_RETURN(const auto c,
                   ReadMatrix(node["principal_point"], path, field + ".principal_point", 2, 2));
  listed.camera.raw = {f[0], f[1], c[0], c[1], {}};
  std::string word = WordOf(node["distortion_type"]);
  // Its own names of lenses, and ours.
  if (word == "radialtangential" || word == "radialtangential8") word = "radial-tangential";
  if (word.empty()) return Bad(path, absl::StrCat(field, ".distortion_type is missing"));
  ASSIGN_OR_RETURN(const auto numbers, ReadLensNumbers(node["distortion_coefficients"], path,
                                                       field + ".distortion_coefficients"));
  ASSIGN_OR_RETURN(listed.camera.raw.lens, LensOf(word, numbers, path, field));
  ASSIGN_OR_RETURN(const PictureSize size,
                   ReadSize(node["image_dimension"], path, field + ".image_dimension"));
  listed.camera.width_px = size.width_px;
  listed.camera.height_px = size.height_px;
  ASSIGN_OR_RETURN(const auto rows, ReadMatrix(node["T_SC"], path, field + ".T_SC", 16, 16));
  ASSIGN_OR_RETURN(listed.body_from_camera, ToRigid(rows, path, field + ".T_SC"));
  return listed;
}

// How the two systems call an IMU's numbers, in a map of one of these names.
struct ImuNames {
  std::vector<const char*> maps;
  const char* rate;
  const char* gyro_noise;
  const char* accel_noise;
  const char* gyro_walk;
  const char* accel_walk;
  const char* delay;  // Which says by which rule the clocks differ, is not told.
};
const ImuNames& SvosImu() {
  static const auto& names =
      *new ImuNames{{"imu_params"},       "imu_rate",         "sigma_omega_c", "sigma_acc_c",
                    "sigma_omega_bias_c", "sigma_acc_bias_c", "delay_imu_cam"};
  return names;
}
const ImuNames& OkvissImu() {
  static const auto& names = *new ImuNames{{"imu_parameters", "imu_params"},
                                           "imu_rate",
                                           "sigma_g_c",
                                           "sigma_a_c",
                                           "sigma_gw_c",
                                           "sigma_aw_c",
                                           "image_delay"};
  return names;
}

// Both systems' cameras are placed in the IMU's frame.
absl::Status ReadImu(const YAML::Node& file, const std::string& path, const ImuNames& names,
                     ConvertedRig& converted) {
  for (const char* const map : names.maps) {
    const YAML::Node node = file[map];
    if (!node.IsDefined() || !node.IsMap()) continue;
    StatedImu& imu = converted.rig.imu.emplace();
    imu.imu_from_camera = *converted.rig.body_from_camera;
    ASSIGN_OR_RETURN(imu.rate_hz, ReadIfThere(node, path, names.rate));
    ASSIGN_OR_RETURN(imu.gyro_noise, ReadIfThere(node, path, names.gyro_noise));
    ASSIGN_OR_RETURN(imu.accel_noise, ReadIfThere(node, path, names.accel_noise));
    ASSIGN_OR_RETURN(imu.gyro_walk, ReadIfThere(node, path, names.gyro_walk));
    ASSIGN_OR_RETURN(imu.accel_walk, ReadIfThere(node, path, names.accel_walk));
    for (const YAML::Node& holder : {node, YAML::Node(file["camera_parameters"])}) {
      if (!holder.IsDefined() || !holder.IsMap()) continue;
      ASSIGN_OR_RETURN(const auto delay_s, ReadIfThere(holder, path, names.delay));
      if (delay_s.value_or(0) == 0) continue;
      converted.notes.push_back(absl::StrCat(names.delay, " of ", *delay_s,
                                             " s is left out: write imu.time_offset_s, what is "
                                             "added to the IMU's stamps to get the camera's "
                                             "clock, into the rig"));
    }
    return absl::OkStatus();
  }
  return absl::OkStatus();
}

absl::Status Read(const YAML::Node& file, const std::string& path, ReadListed read,
                  const ImuNames& imu, ConvertedRig& converted) {
  const YAML::Node cameras = file["cameras"];
  if (!cameras.IsSequence() || cameras.size() == 0) return Bad(path, "cameras lists no camera");
  if (cameras.size() > 2) {
    converted.notes.emplace_back("cameras after the first two are left out: a rig has two cameras");
  }
  ASSIGN_OR_RETURN(const Listed left, read(cameras[0], path, "cameras[0]"));
  if (cameras.size() == 1) {
    UseOneCamera("cameras lists one", left.camera, converted);
  } else {
    ASSIGN_OR_RETURN(const Listed right, read(cameras[1], path, "cameras[1]"));
    converted.rig.cameras = {left.camera, right.camera};
    converted.rig.right_from_left = right.body_from_camera.Inverse() * left.body_from_camera;
  }
  converted.rig.body_from_camera = left.body_from_camera;
  return ReadImu(file, path, imu, converted);
}

absl::StatusOr<ConvertedRig> ReadList(const RigFiles& files, ReadListed read, const ImuNames& imu,
                                      absl::string_view what) {
  return ReadOneFile(files, what,
                     [&](const YAML::Node& file, const std::string& path, ConvertedRig& rig) {
                       return Read(file, path, read, imu, rig);
                     });
}

}  // namespace

absl::StatusOr<ConvertedRig> ReadSvo(const RigFiles& files) {
  return ReadList(files, &ReadSvoCamera, SvosImu(), "SVO's calibration");
}

absl::StatusOr<ConvertedRig> ReadOkvis2(const RigFiles& files) {
  return ReadList(files, &ReadOkvisCamera, OkvissImu(), "OKVIS2's configuration");
}

}  // namespace corbslam::client_agent
