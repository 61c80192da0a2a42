#include "services/observe/metrics/metrics_endpoint.h"

#include <prometheus/text_serializer.h>

#include <iterator>

#include "absl/strings/str_cat.h"

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

class ScrapeHandler : public WebHandler {
 public:
  explicit ScrapeHandler(MetricsEndpoint::Collectables collectables)
      : collectables_(std::move(collectables)) {}

  void Answer(const WebRequest& request, Respond respond) override { respond(Answer(request)); }

 private:
  WebResponse Answer(const WebRequest& request) const {
    if (request.method != "GET" && request.method != "HEAD") {
      WebResponse refusal = TextResponse(405, "metrics are only read");
      refusal.headers["Allow"] = "GET, HEAD";
      return refusal;
    }
    if (request.path != "/metrics") return TextResponse(404, "there is nothing but /metrics");
    return {.body = std::make_shared<const std::string>(Scrape(collectables_))};
  }

  const MetricsEndpoint::Collectables collectables_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<MetricsEndpoint>> MetricsEndpoint::Start(const std::string& address,
                                                                        Collectables collectables) {
  auto handler = std::make_unique<ScrapeHandler>(std::move(collectables));
  auto server = WebServer::Start(address, handler.get());
  if (!server.ok()) {
    return absl::Status(server.status().code(),
                        absl::StrCat("metrics: ", server.status().message()));
  }
  return std::unique_ptr<MetricsEndpoint>(
      new MetricsEndpoint(std::move(handler), *std::move(server)));
}

}  // namespace corbslam::services
