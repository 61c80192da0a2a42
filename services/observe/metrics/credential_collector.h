// Says how the certificates and keys of a process are.
#ifndef CORBSLAM_SERVICES_OBSERVE_METRICS_CREDENTIAL_COLLECTOR_H_
#define CORBSLAM_SERVICES_OBSERVE_METRICS_CREDENTIAL_COLLECTOR_H_

#include <prometheus/collectable.h>

#include <vector>

namespace corbslam::services {

// Reports when the certificates end that this process uses at the moment, and what became of files
// that were changed (services/security/credential_watch.h). Thread-safe.
class CredentialCollector : public prometheus::Collectable {
 public:
  std::vector<prometheus::MetricFamily> Collect() const override;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_METRICS_CREDENTIAL_COLLECTOR_H_
