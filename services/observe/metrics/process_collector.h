// Says what every process says of itself, by the names that Prometheus's own libraries use.
#ifndef CORBSLAM_SERVICES_OBSERVE_METRICS_PROCESS_COLLECTOR_H_
#define CORBSLAM_SERVICES_OBSERVE_METRICS_PROCESS_COLLECTOR_H_

#include <prometheus/collectable.h>

#include <string>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "absl/time/time.h"

namespace corbslam::services {

// Reports time, memory and files, and which program it is in which version. Thread-safe.
class ProcessCollector : public prometheus::Collectable {
 public:
  explicit ProcessCollector(std::string program)
      : program_(std::move(program)), started_(absl::Now()) {}

  std::vector<prometheus::MetricFamily> Collect() const override;

 private:
  const std::string program_;
  const absl::Time started_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_METRICS_PROCESS_COLLECTOR_H_
