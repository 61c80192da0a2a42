// Reads the times of KITTI's pictures: one a line, the n-th for picture n.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_KITTI_TIMES_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_KITTI_TIMES_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/source/lists/timeline.h"

namespace corbslam::client_agent {

// Reads times.txt, in seconds ("1.037359e-01"), or timestamps.txt, as KITTI's raw recordings have
// them ("2011-09-26 13:02:25.964389445", taken as UTC). Returns NOT_FOUND where the file is not
// there; INVALID_ARGUMENT with file and line for what is no time.
absl::StatusOr<std::vector<ListedTime>> ReadKittiTimes(const std::string& path);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_KITTI_TIMES_H_
