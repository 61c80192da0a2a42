#include "services/programs/recording/calibration_json.h"

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client_agent/source/calibration/lens_names.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::LensOfName;
using client_agent::NumbersOf;
using client_agent::Rig;
using client_agent::RigKind;

namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const Camera& camera) {
  return {{"fx_px", camera.fx_px},           {"fy_px", camera.fy_px},
          {"cx_px", camera.cx_px},           {"cy_px", camera.cy_px},
          {"width_px", camera.width_px},     {"height_px", camera.height_px},
          {"baseline_m", camera.baseline_m}, {"close_depth_m", camera.close_depth_m}};
}

Json ToJson(const LensModel& lens) {
  return {{"lens", std::string(NameOf(lens))}, {"lens_numbers", NumbersOf(lens)}};
}

Json ToJson(const RawCamera& raw) {
  return {{"fx_px", raw.fx_px},
          {"fy_px", raw.fy_px},
          {"cx_px", raw.cx_px},
          {"cy_px", raw.cy_px},
          {"lens", ToJson(raw.lens)}};
}

Json ToJson(const std::optional<Rigid3d>& motion) {
  return motion.has_value() ? services::ToJson(*motion) : Json(nullptr);
}

Json ToJson(const std::optional<ImuCalibration>& imu) {
  if (!imu.has_value()) return nullptr;
  return {{"imu_from_camera", services::ToJson(imu->imu_from_camera)},
          {"rate_hz", imu->rate_hz},
          {"time_offset_s", imu->time_offset_s},
          {"gyro_noise", imu->noise.gyro},
          {"accel_noise", imu->noise.accel},
          {"gyro_walk", imu->noise.gyro_walk},
          {"accel_walk", imu->noise.accel_walk}};
}

Json ToJson(const StereoCalibration& stereo) {
  Json json = {{"camera", ToJson(stereo.camera)},
               {"right_cx_offset_px", stereo.right_cx_offset_px},
               {"body_from_raw_left", ToJson(stereo.body_from_raw_left)},
               {"imu", ToJson(stereo.imu)},
               {"raw", nullptr}};
  if (!stereo.raw.has_value()) return json;
  const RawStereo& raw = *stereo.raw;
  json["raw"] = {{"left", ToJson(raw.left)},
                 {"right", ToJson(raw.right)},
                 {"right_from_left", services::ToJson(raw.right_from_left)},
                 {"width_px", raw.width_px},
                 {"height_px", raw.height_px},
                 {"widest_field_deg", raw.widest_field_deg}};
  return json;
}

Json ToJson(const RgbdCalibration& rgbd) {
  return {{"camera", ToJson(rgbd.camera)},
          {"lens", ToJson(rgbd.lens)},
          {"depth_units_per_m", rgbd.depth_units_per_m},
          {"body_from_raw", ToJson(rgbd.body_from_raw)},
          {"imu", ToJson(rgbd.imu)}};
}

Json ToJson(const MonocularCalibration& one) {
  return {{"camera", ToJson(one.camera)},
          {"lens", ToJson(one.lens)},
          {"body_from_raw", ToJson(one.body_from_raw)},
          {"imu", ToJson(one.imu)}};
}

Camera CameraOf(const Json& json) {
  return {.fx_px = json.at("fx_px"),
          .fy_px = json.at("fy_px"),
          .cx_px = json.at("cx_px"),
          .cy_px = json.at("cy_px"),
          .width_px = json.at("width_px"),
          .height_px = json.at("height_px"),
          .baseline_m = json.at("baseline_m"),
          .close_depth_m = json.at("close_depth_m")};
}

absl::StatusOr<LensModel> LensOf(const Json& json) {
  return LensOfName(json.at("lens").get<std::string>(),
                    json.at("lens_numbers").get<std::vector<double>>());
}

absl::StatusOr<RawCamera> RawOf(const Json& json) {
  ASSIGN_OR_RETURN(LensModel lens, LensOf(json.at("lens")));
  return RawCamera{json.at("fx_px"), json.at("fy_px"), json.at("cx_px"), json.at("cy_px"),
                   std::move(lens)};
}

absl::StatusOr<std::optional<Rigid3d>> MotionOf(const Json& json) {
  if (json.is_null()) return std::nullopt;
  ASSIGN_OR_RETURN(const Rigid3d motion, RigidFromJson(json));
  return motion;
}

absl::StatusOr<RawStereo> RawPairOf(const Json& json) {
  RawStereo raw;
  ASSIGN_OR_RETURN(raw.left, RawOf(json.at("left")));
  ASSIGN_OR_RETURN(raw.right, RawOf(json.at("right")));
  ASSIGN_OR_RETURN(raw.right_from_left, RigidFromJson(json.at("right_from_left")));
  raw.width_px = json.at("width_px");
  raw.height_px = json.at("height_px");
  raw.widest_field_deg = json.at("widest_field_deg");
  return raw;
}

// Older recordings do not have it.
absl::StatusOr<std::optional<ImuCalibration>> ImuOf(const Json& calibration) {
  if (!calibration.contains("imu") || calibration.at("imu").is_null()) return std::nullopt;
  const Json& json = calibration.at("imu");
  ImuCalibration imu;
  ASSIGN_OR_RETURN(imu.imu_from_camera, RigidFromJson(json.at("imu_from_camera")));
  imu.rate_hz = json.at("rate_hz");
  imu.time_offset_s = json.at("time_offset_s");
  imu.noise = {json.at("gyro_noise"), json.at("accel_noise"), json.at("gyro_walk"),
               json.at("accel_walk")};
  return imu;
}

absl::StatusOr<SensorCalibration> StereoOf(const Json& json) {
  StereoCalibration stereo;
  stereo.camera = CameraOf(json.at("camera"));
  stereo.right_cx_offset_px = json.at("right_cx_offset_px");
  ASSIGN_OR_RETURN(stereo.body_from_raw_left, MotionOf(json.at("body_from_raw_left")));
  ASSIGN_OR_RETURN(stereo.imu, ImuOf(json));
  if (!json.at("raw").is_null()) {
    ASSIGN_OR_RETURN(stereo.raw, RawPairOf(json.at("raw")));
  }
  return stereo;
}

absl::StatusOr<SensorCalibration> RgbdOf(const Json& json) {
  RgbdCalibration rgbd;
  rgbd.camera = CameraOf(json.at("camera"));
  ASSIGN_OR_RETURN(rgbd.lens, LensOf(json.at("lens")));
  rgbd.depth_units_per_m = json.at("depth_units_per_m");
  ASSIGN_OR_RETURN(rgbd.body_from_raw, MotionOf(json.at("body_from_raw")));
  ASSIGN_OR_RETURN(rgbd.imu, ImuOf(json));
  return rgbd;
}

absl::StatusOr<SensorCalibration> MonocularOf(const Json& json) {
  MonocularCalibration one;
  one.camera = CameraOf(json.at("camera"));
  ASSIGN_OR_RETURN(one.lens, LensOf(json.at("lens")));
  ASSIGN_OR_RETURN(one.body_from_raw, MotionOf(json.at("body_from_raw")));
  ASSIGN_OR_RETURN(one.imu, ImuOf(json));
  return one;
}

client_agent::RigCamera RigCameraOf(const Camera& camera, double cx_px, const LensModel& lens) {
  return {
      {camera.fx_px, camera.fy_px, cx_px, camera.cy_px, lens}, camera.width_px, camera.height_px};
}

// Frames' samples are by the camera's clock already.
std::optional<client_agent::StatedImu> AlignedImu(const std::optional<ImuCalibration>& imu) {
  if (!imu.has_value()) return std::nullopt;
  client_agent::StatedImu stated = client_agent::StatedOf(*imu);
  stated.time_offset_s = 0;
  return stated;
}

Rig StereoRig(const StereoCalibration& stereo) {
  Rig rig;
  const Camera& camera = stereo.camera;
  if (stereo.raw.has_value()) {
    const RawStereo& raw = *stereo.raw;
    rig.cameras = {{raw.left, raw.width_px, raw.height_px},
                   {raw.right, raw.width_px, raw.height_px}};
    rig.right_from_left = raw.right_from_left;
    rig.widest_field_deg = raw.widest_field_deg;
  } else {
    rig.rectified = true;
    rig.baseline_m = camera.baseline_m;
    rig.cameras = {RigCameraOf(camera, camera.cx_px, {}),
                   RigCameraOf(camera, camera.cx_px + stereo.right_cx_offset_px, {})};
  }
  if (camera.close_depth_m > 0) rig.close_depth_m = camera.close_depth_m;
  rig.body_from_camera = stereo.body_from_raw_left;
  rig.imu = AlignedImu(stereo.imu);
  return rig;
}

Rig RgbdRig(const RgbdCalibration& rgbd) {
  Rig rig;
  rig.kind = RigKind::kRgbd;
  rig.cameras = {RigCameraOf(rgbd.camera, rgbd.camera.cx_px, rgbd.lens)};
  rig.depth.units_per_m = rgbd.depth_units_per_m;
  rig.depth.virtual_baseline_m = rgbd.camera.baseline_m;
  if (rgbd.camera.close_depth_m > 0) rig.close_depth_m = rgbd.camera.close_depth_m;
  rig.body_from_camera = rgbd.body_from_raw;
  rig.imu = AlignedImu(rgbd.imu);
  return rig;
}

Rig MonocularRig(const MonocularCalibration& one) {
  Rig rig;
  rig.kind = RigKind::kMonocular;
  rig.cameras = {RigCameraOf(one.camera, one.camera.cx_px, one.lens)};
  rig.body_from_camera = one.body_from_raw;
  rig.imu = AlignedImu(one.imu);
  return rig;
}

}  // namespace

nlohmann::ordered_json ToJson(const Rigid3d& motion) {
  const Eigen::Quaterniond& q = motion.rotation;
  const Eigen::Vector3d& t = motion.translation;
  return Json::array({q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()});
}

nlohmann::ordered_json ToJson(const SensorCalibration& calibration) {
  if (const auto* const stereo = std::get_if<StereoCalibration>(&calibration)) {
    return {{"stereo", ToJson(*stereo)}};
  }
  if (const auto* const rgbd = std::get_if<RgbdCalibration>(&calibration)) {
    return {{"rgbd", ToJson(*rgbd)}};
  }
  return {{"monocular", ToJson(std::get<MonocularCalibration>(calibration))}};
}

absl::StatusOr<Rigid3d> RigidFromJson(const nlohmann::ordered_json& json) {
  if (!json.is_array() || json.size() != 7) {
    return absl::DataLossError(absl::StrCat("a motion is ", json.dump(), ", not seven numbers"));
  }
  for (const Json& number : json) {
    if (number.is_number()) continue;
    return absl::DataLossError(absl::StrCat("a motion holds ", number.dump(), ", no number"));
  }
  // Not normalised anew: that would change the last digits.
  Rigid3d motion;
  motion.rotation = Eigen::Quaterniond(json[0], json[1], json[2], json[3]);
  motion.translation = Eigen::Vector3d(json[4], json[5], json[6]);
  return motion;
}

absl::StatusOr<SensorCalibration> CalibrationFromJson(const nlohmann::ordered_json& json) {
  try {
    if (json.contains("monocular")) return MonocularOf(json.at("monocular"));
    return json.contains("stereo") ? StereoOf(json.at("stereo")) : RgbdOf(json.at("rgbd"));
  } catch (const Json::exception& error) {
    return absl::DataLossError(absl::StrCat("the calibration: ", error.what()));
  }
}

client_agent::Rig RigOf(const SensorCalibration& calibration) {
  if (const auto* const stereo = std::get_if<StereoCalibration>(&calibration)) {
    return StereoRig(*stereo);
  }
  if (const auto* const rgbd = std::get_if<RgbdCalibration>(&calibration)) return RgbdRig(*rgbd);
  return MonocularRig(std::get<MonocularCalibration>(calibration));
}

}  // namespace corbslam::services
