// Saves global adjustments as files: what a worker was asked, to be looked at and done again.
#ifndef CORBSLAM_SERVICES_OBSERVE_ADJUSTMENT_FILES_ADJUSTMENT_FILE_H_
#define CORBSLAM_SERVICES_OBSERVE_ADJUSTMENT_FILES_ADJUSTMENT_FILE_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "slam/exchange/fusion_worker.h"

namespace corbslam::services {

// Writes the messages of the request as a worker gets them, each after its length. UNAVAILABLE
// names the path; then there is no such file.
absl::Status WriteAdjustment(const AdjustBundleRequest& request, const std::string& path);
// Reads what WriteAdjustment wrote. NOT_FOUND if there is no such file; INVALID_ARGUMENT if a
// worker would refuse the request or the file is cut short. Both name the path.
absl::StatusOr<AdjustBundleRequest> ReadAdjustment(const std::string& path);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_ADJUSTMENT_FILES_ADJUSTMENT_FILE_H_
