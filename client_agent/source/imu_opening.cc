#include "client_agent/source/imu_opening.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client_agent/source/lists/imu_list.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr char kNoImu[] = "0";  // ?imu=0

// Names the densities that nobody stated; empty where all are.
std::string UnstatedNoise(const StatedImu& stated) {
  std::vector<const char*> fields;
  if (!stated.gyro_noise.has_value()) fields.push_back("gyro_noise");
  if (!stated.accel_noise.has_value()) fields.push_back("accel_noise");
  if (!stated.gyro_walk.has_value()) fields.push_back("gyro_walk");
  if (!stated.accel_walk.has_value()) fields.push_back("accel_walk");
  return absl::StrJoin(fields, ", ");
}

absl::Status NobodyStatesIt(const SourceSpec& spec) {
  const std::string& rig = spec.opening.rig_file;
  return absl::InvalidArgumentError(
      absl::StrCat("?imu=", spec.opening.imu, ": nothing says where the IMU sits: ",
                   rig.empty() ? "give a rig file with a block imu: (?rig=FILE, docs/rig.md)"
                               : absl::StrCat(rig, " has no block imu: (docs/rig.md)")));
}

ImuExpectation ExpectationOf(const SourceSpec& spec, const std::string& path,
                             const std::vector<ListedFrame>& frames) {
  const auto [first, last] = std::minmax_element(
      frames.begin(), frames.end(),
      [](const ListedFrame& a, const ListedFrame& b) { return a.timestamp_ns < b.timestamp_ns; });
  ImuExpectation expected;
  expected.from = path;
  expected.first_picture_ns = first->timestamp_ns;
  expected.last_picture_ns = last->timestamp_ns;
  expected.trust = spec.opening.trust_calibration;
  return expected;
}

}  // namespace

void SetImu(std::optional<ImuCalibration> imu, SensorCalibration& calibration) {
  std::visit([&](auto& kind) { kind.imu = std::move(imu); }, calibration);
}

absl::Status TakeSamples(const StatedImu& stated, ImuExpectation expected, ImuSamples& samples,
                         SensorCalibration& calibration, SourceDescription& description) {
  expected.rate_hz = stated.rate_hz;
  ShiftTimes(std::llround(1e9 * stated.time_offset_s), samples);
  ASSIGN_OR_RETURN(const ImuStatistics statistics,
                   MeasureImu(samples, expected, description.remarks.findings));
  ImuCalibration imu = CalibrationOf(stated);
  if (!stated.rate_hz.has_value()) imu.rate_hz = statistics.rate_hz;
  SetImu(imu, calibration);
  description.imu = DescribeImu(statistics, expected.from);
  if (const std::string unstated = UnstatedNoise(stated); !unstated.empty()) {
    absl::StrAppend(&description.imu, "; nobody states its ", unstated,
                    ": those of a cheap IMU are taken");
  }
  return absl::OkStatus();
}

absl::Status TakeImu(const SourceSpec& spec, const std::string& own_list,
                     ListedSequence& sequence) {
  SetImu(std::nullopt, sequence.calibration);
  const std::string& named = spec.opening.imu;
  if (named == kNoImu) return absl::OkStatus();
  const std::string& path = named.empty() ? own_list : named;
  std::vector<std::string>& left_out = sequence.description.remarks.left_out;
  if (!sequence.imu.has_value()) {
    if (!named.empty()) return NobodyStatesIt(spec);
    if (path.empty()) return absl::OkStatus();
    left_out.push_back(absl::StrCat(
        path, ": what the IMU measured: nothing says where it sits (a rig file's block imu:, or ",
        "sensor.yaml beside the list)"));
    return absl::OkStatus();
  }
  if (path.empty()) {
    left_out.push_back(absl::StrCat(sequence.description.intrinsics_from,
                                    ": its IMU, of which the recording has no samples (?imu=FILE "
                                    "names them)"));
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(sequence.imu_samples, ReadImuList(path, sequence.description.remarks));
  return TakeSamples(*sequence.imu, ExpectationOf(spec, path, sequence.frames),
                     sequence.imu_samples, sequence.calibration, sequence.description);
}

}  // namespace corbslam::client_agent
