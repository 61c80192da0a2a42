#include <optional>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client_agent/source/calibration/lens_names.h"
#include "client_agent/source/calibration/yaml_fields.h"
#include "client_agent/source/rig/convert/rig_readers.h"
#include "client_agent/source/rig/rectified_motion.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

// The settings of one file.
class Settings {
 public:
  Settings(const std::string& path, const YAML::Node& file) : path_(path), file_(file) {}

  bool Has(const std::string& field) const { return file_[field].IsDefined(); }
  absl::StatusOr<double> Number(const std::string& field) const {
    if (!Has(field)) return Bad(absl::StrCat(field, " is missing"));
    return ReadNumber(file_[field], path_, field);
  }
  // Returns nullopt where the field is not there.
  absl::StatusOr<std::optional<double>> Maybe(const std::string& field) const {
    if (!Has(field)) return std::nullopt;
    ASSIGN_OR_RETURN(const double number, Number(field));
    return number;
  }
  std::string Word(const std::string& field) const {
    return Has(field) && file_[field].IsScalar() ? file_[field].Scalar() : "";
  }
  absl::StatusOr<std::vector<double>> Matrix(const std::string& field, size_t least,
                                             size_t most) const {
    const YAML::Node node = file_[field];
    if (!node.IsDefined()) return Bad(absl::StrCat(field, " is missing"));
    return ReadNumbers(node.IsMap() ? node["data"] : node, path_, field, least, most);
  }
  absl::StatusOr<Rigid3d> Motion(const std::string& field) const {
    ASSIGN_OR_RETURN(const std::vector<double> rows, Matrix(field, 16, 16));
    return ToRigid(rows, path_, field);
  }
  absl::Status Bad(absl::string_view what) const {
    return absl::InvalidArgumentError(absl::StrCat(path_, ": ", what));
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  YAML::Node file_;
};

absl::StatusOr<LensModel> LensOf(const Settings& settings, const std::string& field,
                                 absl::string_view word, const std::vector<double>& numbers) {
  const auto lens = LensOfName(word, numbers);
  if (lens.ok()) return lens;
  return settings.Bad(absl::StrCat(field, ": ", lens.status().message()));
}

// Reads PREFIX.k1 and so on; those that are not there are 0.
absl::StatusOr<LensModel> ReadLens(const Settings& settings, const std::string& prefix) {
  const bool is_fisheye = settings.Word("Camera.type") == "KannalaBrandt8";
  std::vector<double> numbers;
  const std::vector<std::string> names =
      is_fisheye ? std::vector<std::string>{"k1", "k2", "k3", "k4"}
                 : std::vector<std::string>{"k1", "k2", "p1", "p2", "k3"};
  for (const std::string& name : names) {
    ASSIGN_OR_RETURN(const auto number, settings.Maybe(prefix + "." + name));
    numbers.push_back(number.value_or(0));
  }
  return LensOf(settings, prefix, is_fisheye ? "equidistant" : "radial-tangential", numbers);
}

absl::StatusOr<PictureSize> ReadSizeOf(const Settings& settings, const RigFiles& files,
                                       const std::string& width, const std::string& height) {
  if (!settings.Has(width) || !settings.Has(height)) return NeedSize(files);
  ASSIGN_OR_RETURN(const double width_px, settings.Number(width));
  ASSIGN_OR_RETURN(const double height_px, settings.Number(height));
  return ToSize(width_px, height_px, settings.path(), absl::StrCat(width, ", ", height));
}

absl::StatusOr<RigCamera> ReadCamera(const Settings& settings, const RigFiles& files,
                                     const std::string& prefix) {
  RigCamera camera;
  ASSIGN_OR_RETURN(camera.raw.fx_px, settings.Number(prefix + ".fx"));
  ASSIGN_OR_RETURN(camera.raw.fy_px, settings.Number(prefix + ".fy"));
  ASSIGN_OR_RETURN(camera.raw.cx_px, settings.Number(prefix + ".cx"));
  ASSIGN_OR_RETURN(camera.raw.cy_px, settings.Number(prefix + ".cy"));
  ASSIGN_OR_RETURN(camera.raw.lens, ReadLens(settings, prefix));
  ASSIGN_OR_RETURN(const PictureSize size,
                   ReadSizeOf(settings, files, "Camera.width", "Camera.height"));
  camera.width_px = size.width_px;
  camera.height_px = size.height_px;
  return camera;
}

// Reads LEFT.K, LEFT.D, LEFT.R, LEFT.P of ORB-SLAM2's pairs that it rectifies itself.
struct Side {
  RigCamera camera;
  Eigen::Matrix3d rectified_from_camera;
  double shift_px_m = 0;
  double rectified_fx_px = 0;
};

absl::StatusOr<Side> ReadSide(const Settings& settings, const RigFiles& files,
                              const std::string& name) {
  Side side;
  ASSIGN_OR_RETURN(const auto k, settings.Matrix(name + ".K", 9, 9));
  ASSIGN_OR_RETURN(const auto d, settings.Matrix(name + ".D", 4, 14));
  ASSIGN_OR_RETURN(const auto r, settings.Matrix(name + ".R", 9, 9));
  ASSIGN_OR_RETURN(const auto p, settings.Matrix(name + ".P", 12, 12));
  ASSIGN_OR_RETURN(const PictureSize size,
                   ReadSizeOf(settings, files, name + ".width", name + ".height"));
  RETURN_IF_ERROR(CheckCameraMatrix(k, settings.path(), name + ".K"));
  side.camera.raw = {k[0], k[4], k[2], k[5], {}};
  ASSIGN_OR_RETURN(side.camera.raw.lens, LensOf(settings, name + ".D", "radial-tangential", d));
  side.camera.width_px = size.width_px;
  side.camera.height_px = size.height_px;
  side.rectified_from_camera << r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8];
  side.rectified_fx_px = p[0];
  side.shift_px_m = p[3];
  return side;
}

absl::Status ReadRawPair2(const Settings& settings, const RigFiles& files, Rig& rig) {
  ASSIGN_OR_RETURN(const Side left, ReadSide(settings, files, "LEFT"));
  ASSIGN_OR_RETURN(const Side right, ReadSide(settings, files, "RIGHT"));
  rig.cameras = {left.camera, right.camera};
  rig.right_from_left = MotionOfRectified(left.rectified_from_camera, right.rectified_from_camera,
                                          -right.shift_px_m / right.rectified_fx_px);
  return absl::OkStatus();
}

// ORB-SLAM2: Camera.fx, ... and Camera.bf, the baseline in metres times fx.
absl::Status ReadRectified2(const Settings& settings, const RigFiles& files, Rig& rig) {
  ASSIGN_OR_RETURN(const RigCamera camera, ReadCamera(settings, files, "Camera"));
  ASSIGN_OR_RETURN(const double bf_px_m, settings.Number("Camera.bf"));
  rig.cameras = {camera, camera};
  rig.rectified = true;
  rig.baseline_m = bf_px_m / camera.raw.fx_px;
  return absl::OkStatus();
}

// ORB-SLAM3: Camera1, Camera2 and Stereo.T_c1_c2, which maps from the right camera to the left one;
// or, of rectified pairs, Camera1 and Stereo.b.
absl::Status ReadPair3(const Settings& settings, const RigFiles& files, Rig& rig) {
  ASSIGN_OR_RETURN(rig.cameras.emplace_back(), ReadCamera(settings, files, "Camera1"));
  if (settings.Word("Camera.type") == "Rectified") {
    rig.cameras.push_back(rig.cameras[0]);
    rig.rectified = true;
    ASSIGN_OR_RETURN(rig.baseline_m, settings.Number("Stereo.b"));
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(rig.cameras.emplace_back(), ReadCamera(settings, files, "Camera2"));
  ASSIGN_OR_RETURN(const Rigid3d left_from_right, settings.Motion("Stereo.T_c1_c2"));
  rig.right_from_left = left_from_right.Inverse();
  return absl::OkStatus();
}

absl::Status ReadRgbd(const Settings& settings, const RigFiles& files, const std::string& prefix,
                      double units_per_m, Rig& rig) {
  rig.kind = RigKind::kRgbd;
  rig.depth.units_per_m = units_per_m;
  ASSIGN_OR_RETURN(rig.cameras.emplace_back(), ReadCamera(settings, files, prefix));
  return absl::OkStatus();
}

absl::Status ReadCameras(const Settings& settings, const RigFiles& files, ConvertedRig& converted) {
  Rig& rig = converted.rig;
  ASSIGN_OR_RETURN(const auto units2, settings.Maybe("DepthMapFactor"));
  ASSIGN_OR_RETURN(const auto units3, settings.Maybe("RGBD.DepthMapFactor"));
  if (units3.has_value()) return ReadRgbd(settings, files, "Camera1", *units3, rig);
  if (units2.has_value()) return ReadRgbd(settings, files, "Camera", *units2, rig);
  if (settings.Has("Tlr") && !settings.Has("Stereo.T_c1_c2")) {
    return settings.Bad(
        "Tlr is of ORB-SLAM3's older settings, whose format is not known here: write Camera1.fx "
        "..., Camera2.fx ... and Stereo.T_c1_c2 (4x4, from the right camera to the left one), as "
        "its settings of File.version 1.0 have them");
  }
  if (settings.Has("LEFT.K")) return ReadRawPair2(settings, files, rig);
  if (settings.Has("Camera1.fx")) {
    if (settings.Has("Stereo.T_c1_c2") || settings.Has("Stereo.b")) {
      return ReadPair3(settings, files, rig);
    }
  } else if (settings.Has("Camera.bf")) {
    return ReadRectified2(settings, files, rig);
  }
  const std::string prefix = settings.Has("Camera1.fx") ? "Camera1" : "Camera";
  ASSIGN_OR_RETURN(const RigCamera camera, ReadCamera(settings, files, prefix));
  UseOneCamera("neither Camera.bf nor Stereo.T_c1_c2, Stereo.b or DepthMapFactor is there", camera,
               converted);
  return absl::OkStatus();
}

void NoteOtherSize(const Settings& settings, std::vector<std::string>& notes) {
  for (const char* field : {"Camera.newWidth", "Camera.newHeight", "Camera.imageScale"}) {
    if (!settings.Has(field)) continue;
    notes.push_back(absl::StrCat(field,
                                 " is left out: the rig is of pictures in the size that was "
                                 "calibrated; a source's scale=S makes them smaller"));
  }
}

// The camera's frame in the IMU's: Tbc of ORB-SLAM2's time, IMU.T_b_c1 of today's.
absl::Status ReadBody(const Settings& settings, Rig& rig) {
  for (const char* field : {"IMU.T_b_c1", "Tbc"}) {
    if (!settings.Has(field)) continue;
    ASSIGN_OR_RETURN(rig.body_from_camera, settings.Motion(field));
  }
  return absl::OkStatus();
}

// The body is the IMU, where the settings have one.
absl::Status ReadImu(const Settings& settings, Rig& rig) {
  if (!rig.body_from_camera.has_value()) return absl::OkStatus();
  const bool has_imu = settings.Has("IMU.NoiseGyro") || settings.Has("IMU.NoiseAcc") ||
                       settings.Has("IMU.Frequency") || settings.Has("IMU.T_b_c1");
  if (!has_imu) return absl::OkStatus();
  StatedImu& imu = rig.imu.emplace();
  imu.imu_from_camera = *rig.body_from_camera;
  ASSIGN_OR_RETURN(imu.rate_hz, settings.Maybe("IMU.Frequency"));
  ASSIGN_OR_RETURN(imu.gyro_noise, settings.Maybe("IMU.NoiseGyro"));
  ASSIGN_OR_RETURN(imu.accel_noise, settings.Maybe("IMU.NoiseAcc"));
  ASSIGN_OR_RETURN(imu.gyro_walk, settings.Maybe("IMU.GyroWalk"));
  ASSIGN_OR_RETURN(imu.accel_walk, settings.Maybe("IMU.AccWalk"));
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ConvertedRig> ReadOrbSlam(const RigFiles& files) {
  RETURN_IF_ERROR(ExpectFiles(files, 1, "the settings"));
  const std::string& path = files.paths[0];
  ConvertedRig converted;
  RETURN_IF_ERROR(UseYamlFields(path, [&](const YAML::Node& file) -> absl::Status {
    const Settings settings(path, file);
    RETURN_IF_ERROR(ReadCameras(settings, files, converted));
    NoteOtherSize(settings, converted.notes);
    ASSIGN_OR_RETURN(converted.rig.rate_hz, settings.Maybe("Camera.fps"));
    RETURN_IF_ERROR(ReadBody(settings, converted.rig));
    return ReadImu(settings, converted.rig);
  }));
  return converted;
}

}  // namespace corbslam::client_agent
