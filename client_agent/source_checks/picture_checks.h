// Checks whether the pictures of a source are pictures of anything (docs/sources_checks.md has
// every code, the statistic behind it and the measurements behind its limit).
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_PICTURE_CHECKS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_PICTURE_CHECKS_H_

#include "client_agent/source/source_finding.h"
#include "client_agent/source_checks/sample.h"

namespace corbslam::client_agent {

// Checks size, darkness, saturation, contrast, and pictures that repeat: in time, or in both
// cameras of a pair. What holds for a few frames alone (a shutter that opens, a tunnel) is no
// finding. Pure; any thread.
SourceFindings CheckPictures(const SensorCalibration& calibration, const Sample& sample);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_PICTURE_CHECKS_H_
