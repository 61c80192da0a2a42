// The fusion workers of a map store, as its flags name them.
#ifndef CORBSLAM_SERVICES_PROGRAMS_STORE_WORKERS_H_
#define CORBSLAM_SERVICES_PROGRAMS_STORE_WORKERS_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "services/security/security_options.h"
#include "slam/exchange/fusion_worker.h"

namespace corbslam {

// Those at the addresses, as one. Where none of them takes a request, its error has the cause,
// which is looked for at most twice a minute. INVALID_ARGUMENT: the flags of `security` are wrong.
absl::StatusOr<std::unique_ptr<FusionWorker>> ConnectWorkers(
    const std::vector<std::string>& addresses, const SecurityOptions& security);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_PROGRAMS_STORE_WORKERS_H_
