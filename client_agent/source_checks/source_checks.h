// Finds all that can be told about a source from a sample of its frames.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_SOURCE_CHECKS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_SOURCE_CHECKS_H_

#include "client_agent/source/source_finding.h"
#include "client_agent/source_checks/sample.h"
#include "client_agent/source_checks/stereo_checks.h"

namespace corbslam::client_agent {

// Calls CheckPictures, and CheckStereoPair or CheckDepth as the calibration says. Where the
// pictures by themselves show an error, only that is told, and no pair is judged. Pure; any thread.
StereoJudgement JudgeSample(const SensorCalibration& calibration, const Sample& sample);

// Returns the findings alone.
SourceFindings CheckSample(const SensorCalibration& calibration, const Sample& sample);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_SOURCE_CHECKS_H_
