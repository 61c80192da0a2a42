// Opens what tests and measurements take samples from.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_TESTING_SAMPLE_SOURCE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_TESTING_SAMPLE_SOURCE_H_

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/source/source_finding.h"
#include "client_agent/source_checks/sample.h"
#include "client_agent/source_checks/testing/damage.h"

namespace corbslam::client_agent {

struct SampleSource {
  SensorCalibration calibration;
  size_t frames = 0;
  ReadFrame read;
};

// Opens a source by its name, as programs take it.
absl::StatusOr<SampleSource> OpenSampleSource(const std::string& spec);

// Takes the frames that ChooseSampleFrames chooses, damaged.
absl::StatusOr<Sample> TakeSample(const SampleSource& source, const std::string& damage = "",
                                  double amount = 0, const SampleOptions& options = {});

// Writes findings like "error pair-exchanged", "warning pair-late".
std::vector<std::string> CodesOf(const SourceFindings& findings);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_TESTING_SAMPLE_SOURCE_H_
