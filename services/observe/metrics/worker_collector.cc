#include "services/observe/metrics/worker_collector.h"

#include "services/observe/metrics/families.h"

namespace corbslam::services {

std::vector<prometheus::MetricFamily> WorkerCollector::Collect() const {
  Families families;
  families.Gauge("corbslam_worker_requests_held",
                 "Requests that are received, worked on or wait; more than --max-requests are sent "
                 "elsewhere.",
                 service_.requests());
  families.Gauge("corbslam_worker_requests_waiting",
                 "Requests that are received and that no thread has begun with.",
                 static_cast<double>(service_.waiting_requests()));
  return families.Take();
}

}  // namespace corbslam::services
