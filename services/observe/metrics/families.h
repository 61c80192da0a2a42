// Makes metrics from values that are read when somebody asks.
#ifndef CORBSLAM_SERVICES_OBSERVE_METRICS_FAMILIES_H_
#define CORBSLAM_SERVICES_OBSERVE_METRICS_FAMILIES_H_

#include <prometheus/metric_family.h>

#include <string>
#include <utility>
#include <vector>

namespace corbslam::services {

using MetricLabels = std::vector<prometheus::ClientMetric::Label>;

// Collects the metrics of one answer. A family has its series one after the other, and stands in
// the order in which it was first named. Not thread-safe.
class Families {
 public:
  void Gauge(const std::string& name, const std::string& help, double value,
             MetricLabels labels = {});
  // Adds a value that only ever grows; the name ends with "_total".
  void Counter(const std::string& name, const std::string& help, double value,
               MetricLabels labels = {});

  std::vector<prometheus::MetricFamily> Take() { return std::move(families_); }

 private:
  prometheus::ClientMetric& Add(const std::string& name, const std::string& help,
                                prometheus::MetricType type, MetricLabels labels);

  std::vector<prometheus::MetricFamily> families_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_METRICS_FAMILIES_H_
