// Checks whether one camera of a pair is some frames behind the other.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_LATE_CAMERA_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_LATE_CAMERA_H_

#include <optional>
#include <vector>

#include "client_agent/source/source_finding.h"
#include "client_agent/source_checks/pair_sample.h"

namespace corbslam::client_agent {

// Rows agree only between pictures of one time while a camera moves. Returns a finding where the
// right pictures of the frame before (or after) agree better with the left pictures than those of
// the same frame, in nearly all frames that tell the two apart.
std::optional<SourceFinding> CheckLateCamera(const std::vector<JudgedPair>& pairs);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_LATE_CAMERA_H_
