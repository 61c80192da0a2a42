// Checks whether depth images are those of their pictures.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_DEPTH_CHECKS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_DEPTH_CHECKS_H_

#include "client_agent/source/source_finding.h"
#include "client_agent/source_checks/sample.h"

namespace corbslam::client_agent {

// Finds empty, constant or saturated depth; depth that is of another time, seen from elsewhere, or
// not in proportion to the parallax of its picture; units that make the scene a dolls' house or a
// cathedral. A wrong unit within those limits can't be known from pictures: a scene twice as far,
// through which a camera moves twice as fast, looks the same. Pure; any thread.
SourceFindings CheckDepth(const RgbdCalibration& calibration, const Sample& sample);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_DEPTH_CHECKS_H_
