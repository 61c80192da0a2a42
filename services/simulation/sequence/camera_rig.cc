#include "services/simulation/sequence/camera_rig.h"

#include <cmath>
#include <optional>
#include <variant>

namespace corbslam {
namespace {

// The camera of sequence 00 of KITTI's odometry benchmark; nearer than 35 baselines is close, as
// for recordings.
constexpr Camera kKitti = {718.856, 718.856, 607.1928, 185.2157,
                           1241,    376,     0.537166, 35 * 0.537166};
constexpr Camera kEuroc = {458.0, 458.0, 367.2, 248.4, 752, 480, 0.11, 50 * 0.11};
constexpr Camera kRgbd = {525.0, 525.0, 319.5, 239.5, 640, 480, 0.08, 40 * 0.08};

Camera Scaled(Camera camera, double scale) {
  if (scale == 1) return camera;
  camera.fx_px *= scale;
  camera.fy_px *= scale;
  camera.cx_px = (camera.cx_px + 0.5) * scale - 0.5;
  camera.cy_px = (camera.cy_px + 0.5) * scale - 0.5;
  camera.width_px = static_cast<int>(std::lround(camera.width_px * scale));
  camera.height_px = static_cast<int>(std::lround(camera.height_px * scale));
  return camera;
}

// Returns where the right camera is when the robot believes that it is at `left_from_right`.
Rigid3d TrueLeftFromRight(const Rigid3d& left_from_right, double fx_px, double fy_px,
                          const SimulationSpec& spec) {
  // Looking up lowers the picture; looking left shifts it to the right.
  const double up_rad = spec.epipolar_error_px / fy_px;
  const double left_rad = spec.disparity_error_px / fx_px;
  const Eigen::Quaterniond turned = Eigen::AngleAxisd(-left_rad, Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(up_rad, Eigen::Vector3d::UnitX());
  return {(left_from_right.rotation * turned).normalized(),
          left_from_right.translation * (1 + spec.scale_error)};
}

SimulatedRig RigOfPair(const SimulatedPair& pair, const SimulationSpec& spec) {
  SimulatedRig rig;
  rig.calibration = pair.told;
  rig.camera.width_px = pair.width_px;
  rig.camera.height_px = pair.height_px;
  rig.left_from_right =
      TrueLeftFromRight(pair.right_from_left.Inverse(), pair.right.fx_px, pair.right.fy_px, spec);
  constexpr double kUsualRate_hz = 20;
  rig.rate_hz = pair.rate_hz > 0 ? pair.rate_hz : kUsualRate_hz;
  if (spec.rate_hz > 0) rig.rate_hz = spec.rate_hz;
  return rig;
}

SimulatedRig RigOfCameras(const SimulationSpec& spec) {
  SimulatedRig rig;
  switch (RigOf(spec)) {
    case CameraRig::kKitti:
      rig.camera = Scaled(kKitti, spec.picture_scale);
      rig.rate_hz = 10;
      break;
    case CameraRig::kEuroc:
      rig.camera = Scaled(kEuroc, spec.picture_scale);
      rig.rate_hz = 20;
      break;
    case CameraRig::kRgbd:
      rig.camera = Scaled(kRgbd, spec.picture_scale);
      rig.rate_hz = 30;
      break;
  }
  if (spec.rate_hz > 0) rig.rate_hz = spec.rate_hz;
  if (RigOf(spec) == CameraRig::kRgbd) {
    rig.calibration = RgbdCalibration{.camera = rig.camera};
  } else {
    rig.calibration = StereoCalibration{.camera = rig.camera};
    const Rigid3d told = {Eigen::Quaterniond::Identity(), {rig.camera.baseline_m, 0, 0}};
    rig.left_from_right = TrueLeftFromRight(told, rig.camera.fx_px, rig.camera.fy_px, spec);
  }
  return rig;
}

// A rig file says where its IMU sits; what it measures, and how well, the spec does.
void TellImu(const SimulatedImu& imu, std::optional<ImuCalibration>& told) {
  if (!imu.is_there()) {
    told.reset();
    return;
  }
  const Rigid3d imu_from_camera = told.has_value() ? told->imu_from_camera : EurocImuFromCamera();
  told = ToldImu(imu);
  told->imu_from_camera = imu_from_camera;
}

}  // namespace

SimulatedRig MakeRig(const SimulationSpec& spec) {
  SimulatedRig rig = spec.pair.has_value() ? RigOfPair(*spec.pair, spec) : RigOfCameras(spec);
  std::visit([&](auto& calibration) { TellImu(spec.imu, calibration.imu); }, rig.calibration);
  return rig;
}

}  // namespace corbslam
