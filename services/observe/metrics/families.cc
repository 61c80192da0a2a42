#include "services/observe/metrics/families.h"

#include <algorithm>

namespace corbslam::services {

void Families::Gauge(const std::string& name, const std::string& help, double value,
                     MetricLabels labels) {
  Add(name, help, prometheus::MetricType::Gauge, std::move(labels)).gauge.value = value;
}

void Families::Counter(const std::string& name, const std::string& help, double value,
                       MetricLabels labels) {
  Add(name, help, prometheus::MetricType::Counter, std::move(labels)).counter.value = value;
}

prometheus::ClientMetric& Families::Add(const std::string& name, const std::string& help,
                                        prometheus::MetricType type, MetricLabels labels) {
  auto family = std::find_if(families_.begin(), families_.end(),
                             [&name](const auto& known) { return known.name == name; });
  if (family == families_.end()) {
    family = families_.insert(family, prometheus::MetricFamily{name, help, type, {}});
  }
  prometheus::ClientMetric& metric = family->metric.emplace_back();
  metric.label = std::move(labels);
  return metric;
}

}  // namespace corbslam::services
