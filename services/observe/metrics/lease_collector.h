// Says what becomes of the missions that a store shares with others, and of their database.
#ifndef CORBSLAM_SERVICES_OBSERVE_METRICS_LEASE_COLLECTOR_H_
#define CORBSLAM_SERVICES_OBSERVE_METRICS_LEASE_COLLECTOR_H_

#include <prometheus/collectable.h>

#include <vector>

#include "map_store/records/mission_leases.h"

namespace corbslam::services {

// Asks `leases`, which is not owned and must outlive it; null: the missions are not shared, and
// there are no such metrics. Thread-safe.
class LeaseCollector : public prometheus::Collectable {
 public:
  explicit LeaseCollector(const map_store::MissionLeases* leases) : leases_(leases) {}

  std::vector<prometheus::MetricFamily> Collect() const override;

 private:
  const map_store::MissionLeases* const leases_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_METRICS_LEASE_COLLECTOR_H_
