#include "services/observe/metrics/metrics_endpoint.h"

#include <prometheus/text_serializer.h>

#include <iterator>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

std::string Scrape(const MetricsEndpoint::Collectables& collectables) {
  std::vector<prometheus::MetricFamily> families;
  for (const auto& collectable : collectables) {
    std::vector<prometheus::MetricFamily> more = collectable->Collect();
    families.insert(families.end(), std::make_move_iterator(more.begin()),
                    std::make_move_iterator(more.end()));
  }
  return prometheus::TextSerializer().Serialize(families);
}

HttpResponse Answer(const MetricsEndpoint::Collectables& collectables, const HttpRequest& request) {
  if (request.method != "GET" && request.method != "HEAD") {
    return {.status = 405, .body = "metrics are only read\n", .allow = "GET, HEAD"};
  }
  if (request.path != "/metrics") {
    return {.status = 404, .body = "there is nothing but /metrics\n"};
  }
  return {.body = Scrape(collectables)};
}

}  // namespace

absl::Status CheckMetricsAddress(const std::string& address) {
  if (CheckHttpAddress(address).ok()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("the metrics' address is \"", address,
                   "\", must be HOST:PORT with an IP address and a port of 0 to 65535"));
}

absl::StatusOr<std::unique_ptr<MetricsEndpoint>> MetricsEndpoint::Start(const std::string& address,
                                                                        Collectables collectables) {
  RETURN_IF_ERROR(CheckMetricsAddress(address));
  auto server = HttpServer::Start(
      address, [collectables = std::move(collectables)](const HttpRequest& request) {
        return Answer(collectables, request);
      });
  if (!server.ok()) {
    return absl::Status(server.status().code(),
                        absl::StrCat("metrics: ", server.status().message()));
  }
  return std::unique_ptr<MetricsEndpoint>(new MetricsEndpoint(*std::move(server)));
}

}  // namespace corbslam::services
