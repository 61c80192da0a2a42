// VINS-Fusion's configuration: body_T_cam0, body_T_cam1, and the names of the cameras' own files,
// which camodocal writes and which lie beside it.
#include <filesystem>

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

std::string WordOf(const YAML::Node& node) {
  return node.IsDefined() && node.IsScalar() ? node.Scalar() : "";
}

// camodocal's models: in which parts of the file which numbers stand, the lens's first.
struct Model {
  absl::string_view name;
  absl::string_view lens;
  std::vector<std::pair<const char*, std::vector<const char*>>> lens_numbers;
  std::vector<const char*> projection;  // fx, fy, cx, cy by its names.
};

const std::vector<Model>& Models() {
  static const auto& models = *new std::vector<Model>{
      {"PINHOLE",
       "radial-tangential",
       {{"distortion_parameters", {"k1", "k2", "p1", "p2"}}},
       {"fx", "fy", "cx", "cy"}},
      {"MEI",
       "unified",
       {{"mirror_parameters", {"xi"}}, {"distortion_parameters", {"k1", "k2", "p1", "p2"}}},
       {"gamma1", "gamma2", "u0", "v0"}},
      {"KANNALA_BRANDT",
       "equidistant",
       {{"projection_parameters", {"k2", "k3", "k4", "k5"}}},
       {"mu", "mv", "u0", "v0"}}};
  return models;
}

absl::Status AddNumbers(const YAML::Node& file, const char* part,
                        const std::vector<const char*>& names, const std::string& path,
                        std::vector<double>& numbers) {
  for (const char* name : names) {
    const std::string field = absl::StrCat(part, ".", name);
    const YAML::Node number = file[part].IsMap() ? file[part][name] : YAML::Node();
    if (!number.IsDefined() || number.IsNull()) return Bad(path, field + " is missing");
    ASSIGN_OR_RETURN(numbers.emplace_back(), ReadNumber(number, path, field));
  }
  return absl::OkStatus();
}

absl::Status ReadCameraOf(const YAML::Node& file, const std::string& path, RigCamera& camera) {
  const std::string type = WordOf(file["model_type"]);
  for (const Model& model : Models()) {
    if (model.name != type) continue;
    std::vector<double> numbers;
    for (const auto& [part, names] : model.lens_numbers) {
      RETURN_IF_ERROR(AddNumbers(file, part, names, path, numbers));
    }
    ASSIGN_OR_RETURN(const LensModel lens, LensOfName(model.lens, numbers));
    std::vector<double> k;
    RETURN_IF_ERROR(AddNumbers(file, "projection_parameters", model.projection, path, k));
    ASSIGN_OR_RETURN(const double width, ReadNumber(file["image_width"], path, "image_width"));
    ASSIGN_OR_RETURN(const double height, ReadNumber(file["image_height"], path, "image_height"));
    ASSIGN_OR_RETURN(const PictureSize size,
                     ToSize(width, height, path, "image_width, image_height"));
    camera = {{k[0], k[1], k[2], k[3], lens}, size.width_px, size.height_px};
    return absl::OkStatus();
  }
  return Bad(path, absl::StrCat("model_type is '", type,
                                "', known are PINHOLE, MEI and KANNALA_BRANDT: calibrate with one "
                                "of these"));
}

absl::StatusOr<Rigid3d> ReadPlace(const YAML::Node& file, const char* field,
                                  const std::string& path) {
  const YAML::Node node = file[field];
  if (!node.IsDefined()) return Bad(path, absl::StrCat(field, " is missing"));
  ASSIGN_OR_RETURN(const auto rows,
                   ReadNumbers(node.IsMap() ? node["data"] : node, path, field, 16, 16));
  return ToRigid(rows, path, field);
}

// The body is the IMU, where there is one.
absl::Status ReadImu(const YAML::Node& file, const std::string& path, ConvertedRig& converted) {
  ASSIGN_OR_RETURN(const auto has_imu, ReadIfThere(file, path, "imu"));
  if (has_imu.value_or(0) == 0) return absl::OkStatus();
  StatedImu& imu = converted.rig.imu.emplace();
  imu.imu_from_camera = *converted.rig.body_from_camera;
  // What is added to the pictures' stamps to get the IMU's clock.
  ASSIGN_OR_RETURN(const auto td_s, ReadIfThere(file, path, "td"));
  imu.time_offset_s = -td_s.value_or(0);
  if (file["acc_n"].IsDefined() || file["gyr_n"].IsDefined()) {
    converted.notes.emplace_back(
        "acc_n, gyr_n, acc_w and gyr_w are left out: they are what single measurements are "
        "weighted by there, no densities; write imu.gyro_noise and so on into the rig where the "
        "IMU's are known (docs/rig.md)");
  }
  return absl::OkStatus();
}

absl::Status Read(const YAML::Node& file, const std::string& path, ConvertedRig& converted) {
  if (file["model_type"].IsDefined()) {
    return Bad(path,
               "is one camera's file of VINS-Fusion's: give the configuration that names it "
               "(cam0_calib, cam1_calib) and says where both cameras are");
  }
  Rig& rig = converted.rig;
  for (const char* field : {"cam0_calib", "cam1_calib"}) {
    const std::string name = WordOf(file[field]);
    if (name.empty()) {
      return Bad(path, absl::StrCat(field,
                                    " is missing: a stereo pair has cam0 (left) and cam1 (right); "
                                    "with one camera the map has no scale"));
    }
    const std::string beside = (std::filesystem::path(path).parent_path() / name).string();
    RigCamera& camera = rig.cameras.emplace_back();
    RETURN_IF_ERROR(UseYamlFields(beside, [&](const YAML::Node& of_camera) {
      return ReadCameraOf(of_camera, beside, camera);
    }));
  }
  ASSIGN_OR_RETURN(const Rigid3d body_from_left, ReadPlace(file, "body_T_cam0", path));
  ASSIGN_OR_RETURN(const Rigid3d body_from_right, ReadPlace(file, "body_T_cam1", path));
  rig.right_from_left = body_from_right.Inverse() * body_from_left;
  rig.body_from_camera = body_from_left;
  return ReadImu(file, path, converted);
}

}  // namespace

absl::StatusOr<ConvertedRig> ReadVinsFusion(const RigFiles& files) {
  return ReadOneFile(files, "VINS-Fusion's configuration", &Read);
}

}  // namespace corbslam::client_agent
