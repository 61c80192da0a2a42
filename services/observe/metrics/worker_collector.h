// Counts what waits at a fusion worker.
#ifndef CORBSLAM_SERVICES_OBSERVE_METRICS_WORKER_COLLECTOR_H_
#define CORBSLAM_SERVICES_OBSERVE_METRICS_WORKER_COLLECTOR_H_

#include <prometheus/collectable.h>

#include <vector>

#include "services/fusion_worker_service/fusion_worker_service.h"

namespace corbslam::services {

// Asks `service`, which is not owned and must outlive it. Thread-safe.
class WorkerCollector : public prometheus::Collectable {
 public:
  explicit WorkerCollector(const FusionWorkerService* service) : service_(*service) {}

  std::vector<prometheus::MetricFamily> Collect() const override;

 private:
  const FusionWorkerService& service_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_METRICS_WORKER_COLLECTOR_H_
