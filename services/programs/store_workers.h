// Connects a map store to the fusion workers that its flags name.
#ifndef CORBSLAM_SERVICES_PROGRAMS_STORE_WORKERS_H_
#define CORBSLAM_SERVICES_PROGRAMS_STORE_WORKERS_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "services/security/security_options.h"
#include "slam/exchange/fusion_worker.h"

namespace corbslam::services {

// Returns the workers at the addresses as one. If none of them takes a request, its error has the
// cause, which is looked for at most twice a minute. INVALID_ARGUMENT if the flags of `security`
// are wrong.
absl::StatusOr<std::unique_ptr<FusionWorker>> ConnectWorkers(
    const std::vector<std::string>& addresses, const SecurityOptions& security);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_STORE_WORKERS_H_
