#include <algorithm>
#include <optional>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client_agent/source/calibration/imu_noise_fields.h"
#include "client_agent/source/calibration/lens_names.h"
#include "client_agent/source/calibration/yaml_fields.h"
#include "client_agent/source/rig/convert/rig_readers.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

// How a camera model's intrinsics are written: so many numbers of the lens stand before the focal
// lengths and the principal point.
struct Model {
  absl::string_view name;
  size_t lens_numbers;
  absl::string_view lens;  // Empty: distortion_model says it.
};
constexpr Model kModels[] = {
    {"pinhole", 0, ""}, {"omni", 1, "unified"}, {"ds", 2, "double-sphere"}};

absl::Status Bad(const std::string& path, absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat(path, ": ", what));
}

absl::StatusOr<Model> FindModel(const YAML::Node& camera, const std::string& path,
                                const std::string& name) {
  const YAML::Node node = camera["camera_model"];
  const std::string word = node.IsDefined() && node.IsScalar() ? node.Scalar() : "";
  for (const Model& model : kModels) {
    if (model.name == word) return model;
  }
  return Bad(path, absl::StrCat(name, ".camera_model is '", word,
                                "', known are pinhole, omni and ds: calibrate with one of these"));
}

absl::StatusOr<LensModel> ReadLens(const YAML::Node& camera, const Model& model,
                                   const std::vector<double>& intrinsics, const std::string& path,
                                   const std::string& name) {
  std::vector<double> numbers(intrinsics.begin(),
                              intrinsics.begin() + static_cast<std::ptrdiff_t>(model.lens_numbers));
  const YAML::Node word = camera["distortion_model"];
  const std::string distortion = word.IsDefined() && word.IsScalar() ? word.Scalar() : "none";
  const std::string field = absl::StrCat(name, ".distortion_coeffs");
  if (distortion != "none") {
    ASSIGN_OR_RETURN(const auto more, ReadNumbers(camera["distortion_coeffs"], path, field, 1, 14));
    numbers.insert(numbers.end(), more.begin(), more.end());
  } else if (const YAML::Node unused = camera["distortion_coeffs"]; unused.IsDefined()) {
    ASSIGN_OR_RETURN(const auto none, ReadNumbers(unused, path, field, 0, 14));
    if (std::any_of(none.begin(), none.end(), [](double number) { return number != 0; })) {
      return Bad(path, absl::StrCat(name, ".distortion_model is ",
                                    word.IsDefined() ? "none" : "missing", ", and ", field,
                                    " has numbers: say which lens they are of (radtan, "
                                    "equidistant), or leave them out"));
    }
  }
  if (!model.lens.empty() && distortion != "none" && distortion != "radtan") {
    return Bad(path,
               absl::StrCat(name, ".distortion_model is '", distortion, "' of a camera that is ",
                            model.name, ", known are none and radtan"));
  }
  const auto lens = LensOfName(model.lens.empty() ? distortion : model.lens, numbers);
  if (lens.ok()) return lens;
  return Bad(path, absl::StrCat(name, ".distortion_model: ", lens.status().message()));
}

absl::StatusOr<RigCamera> ReadCamera(const YAML::Node& camera, const std::string& path,
                                     const std::string& name) {
  if (!camera.IsMap()) return Bad(path, absl::StrCat(name, " holds no fields"));
  ASSIGN_OR_RETURN(const Model model, FindModel(camera, path, name));
  const size_t count = model.lens_numbers + 4;
  ASSIGN_OR_RETURN(
      const std::vector<double> k,
      ReadNumbers(camera["intrinsics"], path, absl::StrCat(name, ".intrinsics"), count, count));
  ASSIGN_OR_RETURN(const PictureSize size,
                   ReadSize(camera["resolution"], path, absl::StrCat(name, ".resolution")));
  ASSIGN_OR_RETURN(const LensModel lens, ReadLens(camera, model, k, path, name));
  const size_t first = model.lens_numbers;
  RigCamera read;
  read.raw = {k[first], k[first + 1], k[first + 2], k[first + 3], lens};
  read.width_px = size.width_px;
  read.height_px = size.height_px;
  return read;
}

absl::StatusOr<Rigid3d> ReadMotion(const YAML::Node& node, const std::string& path,
                                   const std::string& field) {
  ASSIGN_OR_RETURN(const std::vector<double> rows, ReadNumbers(node, path, field, 16, 16));
  return ToRigid(rows, path, field);
}

// Kalibr's is what makes a stamp the IMU's; a rig keeps by how much the cameras differ. Nothing is
// known of that where one camera alone has it.
absl::Status ReadTimeShifts(const YAML::Node& file, const std::string& path, Rig& rig) {
  const char* field = "timeshift_cam_imu";
  size_t given = 0;
  for (size_t i = 0; i < rig.cameras.size(); ++i) {
    const std::string name = absl::StrCat("cam", i);
    const YAML::Node shift = file[name][field];
    if (!shift.IsDefined()) continue;
    ++given;
    ASSIGN_OR_RETURN(rig.cameras[i].time_offset_s,
                     ReadNumber(shift, path, absl::StrCat(name, ".", field)));
  }
  const bool is_zero = std::all_of(rig.cameras.begin(), rig.cameras.end(),
                                   [](const auto& camera) { return camera.time_offset_s == 0; });
  if (given != 1 || is_zero || rig.cameras.size() == 1) return absl::OkStatus();
  return Bad(path, absl::StrCat(field,
                                " is of one of cam0 and cam1 alone, so that nobody knows by "
                                "how much they differ: give it of both, or of neither where the "
                                "cameras take their pictures together"));
}

// Takes the first camera's clock for the rig's. Returns by how much the IMU's is ahead of it.
double KeepTimeDifference(Rig& rig) {
  const double shift_s = rig.cameras[0].time_offset_s;
  for (RigCamera& camera : rig.cameras) camera.time_offset_s -= shift_s;
  return shift_s;
}

// Kalibr's imu.yaml, as it is given to it or (below imu0) as it writes it.
absl::Status ReadImuFile(const YAML::Node& file, const std::string& path, StatedImu& imu,
                         std::vector<std::string>& notes) {
  const YAML::Node fields = file["imu0"].IsDefined() ? file["imu0"] : file;
  if (!fields.IsMap()) return Bad(path, "imu0 holds no fields");
  RETURN_IF_ERROR(ReadKalibrNoise(fields, path, imu));
  ASSIGN_OR_RETURN(imu.rate_hz, ReadIfThere(fields, path, "update_rate"));
  if (!imu.gyro_noise.has_value() && !imu.accel_noise.has_value()) {
    return Bad(path,
               "is no imu.yaml of Kalibr's: it has neither gyroscope_noise_density nor "
               "accelerometer_noise_density");
  }
  if (file["imu1"].IsDefined()) notes.push_back("imu1 and those after it are left out");
  ASSIGN_OR_RETURN(const auto offset_s, ReadIfThere(fields, path, "time_offset"));
  if (offset_s.value_or(0) == 0) return absl::OkStatus();
  return Bad(path, absl::StrCat("imu0.time_offset is ", *offset_s,
                                ": of the first IMU it is 0, else nobody knows whose clock "
                                "timeshift_cam_imu is of"));
}

// Which of the two files is the camchain is told by its cameras.
absl::Status PutCamchainFirst(std::vector<std::string>& paths) {
  return UseYamlFields(paths[0], [&](const YAML::Node& file) {
    if (!file["cam0"].IsDefined()) std::swap(paths[0], paths[1]);
    return absl::OkStatus();
  });
}

absl::Status AddImuFile(const std::string& path, ConvertedRig& converted) {
  std::optional<StatedImu>& imu = converted.rig.imu;
  const bool is_placed = imu.has_value();
  StatedImu read = imu.value_or(StatedImu());
  RETURN_IF_ERROR(UseYamlFields(path, [&](const YAML::Node& file) {
    return ReadImuFile(file, path, read, converted.notes);
  }));
  if (is_placed) {
    imu = read;
    return absl::OkStatus();
  }
  return Bad(path,
             "says how an IMU measures, but the camchain does not say where it sits "
             "(cam0.T_cam_imu): give camchain-imucam.yaml, which Kalibr's second step writes");
}

absl::Status Read(const YAML::Node& file, const std::string& path, ConvertedRig& converted) {
  if (!file["cam0"].IsDefined()) return Bad(path, "cam0 is missing");
  const bool is_pair = file["cam1"].IsDefined();
  if (file["cam2"].IsDefined()) {
    converted.notes.emplace_back("cam2 and those after it are left out: a rig has two cameras");
  }
  Rig& rig = converted.rig;
  for (const std::string& name :
       is_pair ? std::vector<std::string>{"cam0", "cam1"} : std::vector<std::string>{"cam0"}) {
    ASSIGN_OR_RETURN(rig.cameras.emplace_back(), ReadCamera(file[name], path, name));
    if (file[name]["distortion_model"].IsDefined()) continue;
    converted.notes.push_back(
        absl::StrCat(name, " has no distortion_model: its lens is taken not to distort"));
  }
  RETURN_IF_ERROR(ReadTimeShifts(file, path, rig));
  const double shift_s = KeepTimeDifference(rig);
  if (is_pair) {
    ASSIGN_OR_RETURN(rig.right_from_left,
                     ReadMotion(file["cam1"]["T_cn_cnm1"], path, "cam1.T_cn_cnm1"));
  } else {
    UseOneCamera("there is no cam1", RigCamera(rig.cameras[0]), converted);
  }
  if (!file["cam0"]["T_cam_imu"].IsDefined()) {
    if (shift_s != 0) {
      converted.notes.push_back(absl::StrCat(
          "cam0.timeshift_cam_imu of ", shift_s,
          " s is left out, but for how much cam1's differs: cam0.T_cam_imu is missing, "
          "which would say where the IMU sits"));
    }
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(const Rigid3d camera_from_imu,
                   ReadMotion(file["cam0"]["T_cam_imu"], path, "cam0.T_cam_imu"));
  rig.body_from_camera = camera_from_imu.Inverse();
  rig.imu = StatedImu{.imu_from_camera = *rig.body_from_camera, .time_offset_s = -shift_s};
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ConvertedRig> ReadKalibr(const RigFiles& files) {
  const bool has_imu_file = files.paths.size() == 2;
  RigFiles camchain = files;
  std::string imu_path;
  if (has_imu_file) {
    RETURN_IF_ERROR(PutCamchainFirst(camchain.paths));
    imu_path = camchain.paths[1];
    camchain.paths.pop_back();
  }
  ASSIGN_OR_RETURN(ConvertedRig converted,
                   ReadOneFile(camchain, "Kalibr's camchain.yaml, and its imu.yaml", &Read));
  if (has_imu_file) RETURN_IF_ERROR(AddImuFile(imu_path, converted));
  return converted;
}

}  // namespace corbslam::client_agent
