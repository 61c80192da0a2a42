// Serves this process's metrics to Prometheus: GET /metrics.
#ifndef CORBSLAM_SERVICES_OBSERVE_METRICS_METRICS_ENDPOINT_H_
#define CORBSLAM_SERVICES_OBSERVE_METRICS_METRICS_ENDPOINT_H_

#include <prometheus/collectable.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "services/http/web_server.h"

namespace corbslam::services {

// A read-only HTTP server without TLS and without a password: for a loopback address or a network
// of the operators' own. /metrics takes GET and HEAD; other methods get 405, other paths 404. Each
// scrape asks the collectables on the server's thread, one scrape after the other.
class MetricsEndpoint {
 public:
  using Collectables = std::vector<std::shared_ptr<prometheus::Collectable>>;

  // Listens on an address that CheckHttpAddress takes; for port 0 the system chooses one. The
  // destructor waits for a scrape that is under way. UNAVAILABLE if it can't listen; the message
  // says why.
  static absl::StatusOr<std::unique_ptr<MetricsEndpoint>> Start(const std::string& address,
                                                                Collectables collectables);

  // Returns "HOST:PORT" with the port that was chosen.
  const std::string& address() const { return server_->address(); }

 private:
  MetricsEndpoint(std::unique_ptr<WebHandler> handler, std::unique_ptr<WebServer> server)
      : handler_(std::move(handler)), server_(std::move(server)) {}

  const std::unique_ptr<WebHandler> handler_;
  // Declared last, so that it ends first.
  const std::unique_ptr<WebServer> server_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_METRICS_METRICS_ENDPOINT_H_
