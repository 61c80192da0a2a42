// Gives times to pictures that have none, from a rate that the user states.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_FRAME_RATE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_FRAME_RATE_H_

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client_agent/source/lists/timeline.h"

namespace corbslam::client_agent {

// Returns the time n / fps seconds for picture n.
std::vector<ListedTime> TimesAtRate(double fps, size_t count);

// Returns NOT_FOUND, saying how a rate is stated. `path` is the file that would have had the times.
absl::Status NoTimes(const std::string& path);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_FRAME_RATE_H_
