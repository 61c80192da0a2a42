// Counts what a map store holds, when somebody asks.
#ifndef CORBSLAM_SERVICES_OBSERVE_METRICS_MISSION_COLLECTOR_H_
#define CORBSLAM_SERVICES_OBSERVE_METRICS_MISSION_COLLECTOR_H_

#include <prometheus/collectable.h>

#include <vector>

#include "map_store/store/map_store.h"
#include "services/map_store_service/map_store_service.h"
#include "services/observe/metrics/ingest_metrics.h"

namespace corbslam::services {

// Takes each mission's reader lock once, for as long as it takes to count its local maps. A deleted
// mission's series are gone with it. Thread-safe.
class MissionCollector : public prometheus::Collectable {
 public:
  // Nothing is owned, and all must outlive it.
  MissionCollector(const map_store::MapStore* store, const MapStoreService* service,
                   IngestMetrics* ingest)
      : store_(*store), service_(*service), ingest_(*ingest) {}

  std::vector<prometheus::MetricFamily> Collect() const override;

 private:
  const map_store::MapStore& store_;
  const MapStoreService& service_;
  IngestMetrics& ingest_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_METRICS_MISSION_COLLECTOR_H_
