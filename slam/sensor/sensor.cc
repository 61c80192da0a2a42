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

}  // namespace corbslam
