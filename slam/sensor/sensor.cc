#include "slam/sensor/sensor.h"

#include "slam/sensor/rgbd_sensor.h"
#include "slam/sensor/stereo_sensor.h"
#include "slam/util/status_macros.h"

namespace corbslam {

absl::StatusOr<std::unique_ptr<Sensor>> MakeSensor(const SensorCalibration& calibration,
                                                   const SensorOptions& options) {
  RETURN_IF_ERROR(options.orb.Validate());
  if (const auto* const stereo = std::get_if<StereoCalibration>(&calibration)) {
    return StereoSensor::Make(*stereo, options);
  }
  return RgbdSensor::Make(std::get<RgbdCalibration>(calibration), options);
}

absl::StatusOr<RecordedCamera> RecordedCameraOf(const SensorCalibration& calibration) {
  RecordedCamera recorded;
  if (const auto* const rgbd = std::get_if<RgbdCalibration>(&calibration)) {
    recorded = AsRecorded(rgbd->camera);
    recorded.lens.lens = rgbd->lens;
    recorded.body_from_recorded = rgbd->body_from_raw;
    return recorded;
  }
  const auto& stereo = std::get<StereoCalibration>(calibration);
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

}  // namespace corbslam
