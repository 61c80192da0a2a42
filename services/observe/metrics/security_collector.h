// Says how the certificates and keys of a process are, and which calls it refused.
#ifndef CORBSLAM_SERVICES_OBSERVE_METRICS_SECURITY_COLLECTOR_H_
#define CORBSLAM_SERVICES_OBSERVE_METRICS_SECURITY_COLLECTOR_H_

#include <prometheus/collectable.h>

#include <vector>

namespace corbslam::services {

// Reports when the certificates end that this process uses at the moment, what became of files that
// were changed (services/security/credential_watch.h), and what its servers' audit logs counted
// (services/security/audit_log.h). Thread-safe.
class SecurityCollector : public prometheus::Collectable {
 public:
  std::vector<prometheus::MetricFamily> Collect() const override;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_METRICS_SECURITY_COLLECTOR_H_
