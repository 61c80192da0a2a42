#include "slam/sensor/sensor.h"

#include "slam/sensor/monocular_sensor.h"
#include "slam/sensor/rgbd_sensor.h"
#include "slam/sensor/stereo_sensor.h"
#include "slam/util/status_macros.h"

namespace corbslam {

namespace {

Camera WithoutDepth(Camera camera) {
  camera.baseline_m = 0;
  camera.close_depth_m = 0;
  return camera;
}

RecordedCamera Recorded(const MonocularCalibration& calibration) {
  RecordedCamera recorded = AsRecorded(calibration.camera);
  recorded.lens.lens = calibration.lens;
  recorded.body_from_recorded = calibration.body_from_raw;
  return recorded;
}

absl::StatusOr<RecordedCamera> RecordedLeft(const StereoCalibration& stereo) {
  RecordedCamera recorded;
  if (stereo.raw.has_value()) {
    ASSIGN_OR_RETURN(const StereoRectifier rectifier, StereoRectifier::Make(*stereo.raw));
    recorded.lens = stereo.raw->left;
    recorded.camera_from_recorded = rectifier.rectified_from_raw_left();
  } else {
    recorded = AsRecorded(stereo.camera);
  }
  recorded.body_from_recorded = stereo.body_from_raw_left;
  return recorded;
}

MonocularCalibration LeftOf(const StereoCalibration& stereo) {
  MonocularCalibration left;
  left.camera = WithoutDepth(stereo.camera);
  if (stereo.raw.has_value()) {
    const RawStereo& raw = *stereo.raw;
    left.camera = {.fx_px = raw.left.fx_px,
                   .fy_px = raw.left.fy_px,
                   .cx_px = raw.left.cx_px,
                   .cy_px = raw.left.cy_px,
                   .width_px = raw.width_px,
                   .height_px = raw.height_px};
    left.lens = raw.left.lens;
  }
  left.body_from_raw = stereo.body_from_raw_left;
  left.mask = stereo.mask;
  left.imu = stereo.imu;
  return left;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Sensor>> MakeSensor(const SensorCalibration& calibration,
                                                   const SensorOptions& options) {
  RETURN_IF_ERROR(options.orb.Validate());
  switch (KindOf(calibration)) {
    case SensorKind::kStereo:
      return StereoSensor::Make(std::get<StereoCalibration>(calibration), options);
    case SensorKind::kRgbd:
      return RgbdSensor::Make(std::get<RgbdCalibration>(calibration), options);
    case SensorKind::kMonocular:
      break;
  }
  return MonocularSensor::Make(std::get<MonocularCalibration>(calibration), options);
}

MonocularCalibration FirstCameraOf(const SensorCalibration& calibration) {
  if (const auto* const stereo = std::get_if<StereoCalibration>(&calibration)) {
    return LeftOf(*stereo);
  }
  if (const auto* const one = std::get_if<MonocularCalibration>(&calibration)) return *one;
  const auto& rgbd = std::get<RgbdCalibration>(calibration);
  return {.camera = WithoutDepth(rgbd.camera),
          .lens = rgbd.lens,
          .body_from_raw = rgbd.body_from_raw,
          .mask = rgbd.mask,
          .imu = rgbd.imu};
}

absl::StatusOr<RecordedCamera> RecordedCameraOf(const SensorCalibration& calibration) {
  if (const auto* const stereo = std::get_if<StereoCalibration>(&calibration)) {
    return RecordedLeft(*stereo);
  }
  if (const auto* const rgbd = std::get_if<RgbdCalibration>(&calibration)) {
    RecordedCamera recorded = AsRecorded(rgbd->camera);
    recorded.lens.lens = rgbd->lens;
    recorded.body_from_recorded = rgbd->body_from_raw;
    return recorded;
  }
  return Recorded(std::get<MonocularCalibration>(calibration));
}

}  // namespace corbslam
