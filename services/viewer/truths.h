// Where the cameras of missions really were, for pages to draw.
#ifndef CORBSLAM_SERVICES_VIEWER_TRUTHS_H_
#define CORBSLAM_SERVICES_VIEWER_TRUTHS_H_

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace corbslam::services {

// By mission: rows as TUM's, "time tx ty tz qx qy qz qw", of the robots' recorded cameras, all in
// one frame; times in seconds by the clock of the robots' pictures.
using Truths = std::map<std::string, std::shared_ptr<const std::string>>;

// Reads flags "MISSION=FILE", FILE a trajectory in TUM's format. INVALID_ARGUMENT names the flag
// and what is wrong: not of that form, a mission twice, a file that can't be read or has more than
// a million poses.
absl::StatusOr<Truths> ReadTruths(const std::vector<std::string>& flags);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_VIEWER_TRUTHS_H_
