// Where Prometheus reads this process's metrics: GET /metrics.
#ifndef CORBSLAM_SERVICES_METRICS_METRICS_ENDPOINT_H_
#define CORBSLAM_SERVICES_METRICS_METRICS_ENDPOINT_H_

#include <prometheus/collectable.h>
#include <prometheus/exposer.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace corbslam {

// "HOST:PORT", HOST an IP address, a port of 0 to 65535. INVALID_ARGUMENT otherwise.
absl::Status CheckMetricsAddress(const std::string& address);

// HTTP without TLS and without a password, read-only: for a loopback address or a network of the
// operators' own. Each scrape asks the collectables on a thread of the endpoint.
class MetricsEndpoint {
 public:
  using Collectables = std::vector<std::shared_ptr<prometheus::Collectable>>;

  // On an address that CheckMetricsAddress takes; port 0: the system chooses one. The destructor
  // waits for scrapes that are under way. UNAVAILABLE where it can't listen.
  static absl::StatusOr<std::unique_ptr<MetricsEndpoint>> Start(const std::string& address,
                                                                Collectables collectables);

  // "HOST:PORT" with the port that was chosen.
  const std::string& address() const { return address_; }

 private:
  MetricsEndpoint(std::unique_ptr<prometheus::Exposer> exposer, std::string address,
                  Collectables collectables);

  const std::string address_;
  const Collectables collectables_;
  std::unique_ptr<prometheus::Exposer> exposer_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_METRICS_METRICS_ENDPOINT_H_
