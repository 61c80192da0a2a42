// Judges whether what an IMU is said to have measured can be: units, clock, gaps, saturation.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_IMU_CHECKS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_IMU_CHECKS_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "client_agent/source/source_finding.h"
#include "slam/inertial/imu.h"

namespace corbslam::client_agent {

// What samples are held against.
struct ImuExpectation {
  std::string from;  // The file or topic, named in messages.
  // The earliest and latest picture, by the clock of the samples.
  int64_t first_picture_ns = 0;
  int64_t last_picture_ns = 0;
  std::optional<double> rate_hz;  // As a calibration states it.
  bool trust = false;             // Also what no IMU measures is taken (?trust-calibration).
};

struct ImuStatistics {
  size_t samples = 0;
  double rate_hz = 0;  // Of the median interval.
  int64_t first_ns = 0;
  int64_t last_ns = 0;
  // While pictures were taken: intervals in which samples are missing.
  size_t gaps = 0;
  double longest_gap_s = 0;
};

// Measures samples that are in the order of time, of which there are at least two. Adds warnings
// for what is improbable (docs/sources_checks.md has the limits). Returns INVALID_ARGUMENT where
// nothing right can come of them: times in another unit, or none that pictures have; accelerations
// in g or without gravity; a sensor that measures one value all the time.
absl::StatusOr<ImuStatistics> MeasureImu(const ImuSamples& samples, const ImuExpectation& expected,
                                         SourceFindings& findings);

// Says for people "200 Hz, 3190 samples from ... to ... s, from FILE; no gaps".
std::string DescribeImu(const ImuStatistics& statistics, const std::string& from);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_IMU_CHECKS_H_
