// Takes what an IMU measured into a recording that is opened.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_IMU_OPENING_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_IMU_OPENING_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client_agent/source/calibration/stated_imu.h"
#include "client_agent/source/listed_reader.h"
#include "client_agent/source/lists/imu_checks.h"
#include "client_agent/source/source_description.h"
#include "client_agent/source/source_spec.h"
#include "slam/sensor/sensor.h"

namespace corbslam::client_agent {

void SetImu(std::optional<ImuCalibration> imu, SensorCalibration& calibration);

// Judges samples that are in the order of time, stamped by the IMU's own clock, and moves them to
// the camera's; puts the IMU into the calibration and the description. Returns MeasureImu's errors.
absl::Status TakeSamples(const StatedImu& stated, ImuExpectation expected, ImuSamples& samples,
                         SensorCalibration& calibration, SourceDescription& description);

// Puts the samples of ?imu=FILE, or of `own_list` where the recording has one (else it is empty),
// into `sequence`, whose calibration and frames are there. Without samples, without anybody who
// states where the IMU sits, or with ?imu=0 the recording has no IMU, and the description says why.
// INVALID_ARGUMENT names the file: ?imu=FILE without a statement, and as ReadImuList and
// MeasureImu.
absl::Status TakeImu(const SourceSpec& spec, const std::string& own_list, ListedSequence& sequence);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_IMU_OPENING_H_
