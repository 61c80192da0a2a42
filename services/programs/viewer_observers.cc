#include "services/programs/viewer_observers.h"

#include <prometheus/collectable.h>

#include <utility>
#include <vector>

#include "services/observe/metrics/families.h"
#include "services/observe/metrics/process_collector.h"
#include "services/observe/metrics/security_collector.h"
#include "services/server/server.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

class ViewerCollector : public prometheus::Collectable {
 public:
  ViewerCollector(const Viewer& viewer, const WebServer& server)
      : viewer_(viewer), server_(server) {}

  std::vector<prometheus::MetricFamily> Collect() const override {
    Families families;
    families.Gauge("corbslam_viewer_pages", "Pages that follow a mission at this moment.",
                   static_cast<double>(server_.streams()));
    families.Gauge("corbslam_viewer_missions",
                   "Missions that are followed for pages; each once, however many pages there are.",
                   static_cast<double>(viewer_.missions()));
    return families.Take();
  }

 private:
  const Viewer& viewer_;
  const WebServer& server_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<MetricsEndpoint>> ServeViewerMetrics(const ObserveFlags& flags,
                                                                    const Viewer& viewer,
                                                                    const WebServer& server) {
  if (flags.metrics_listen.empty()) return nullptr;
  ASSIGN_OR_RETURN(auto endpoint,
                   MetricsEndpoint::Start(flags.metrics_listen,
                                          {std::make_shared<ProcessCollector>("map_viewer"),
                                           std::make_shared<SecurityCollector>(),
                                           std::make_shared<ViewerCollector>(viewer, server)}));
  AnnounceMetrics(endpoint->address());
  return endpoint;
}

}  // namespace corbslam::services
