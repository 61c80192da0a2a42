// Reads single values out of what was collected.
#ifndef CORBSLAM_SERVICES_OBSERVE_METRICS_TESTING_METRIC_VALUES_H_
#define CORBSLAM_SERVICES_OBSERVE_METRICS_TESTING_METRIC_VALUES_H_

#include <prometheus/metric_family.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace corbslam::testing {

using MetricFamilies = std::vector<prometheus::MetricFamily>;
using LabelMap = std::map<std::string, std::string>;

struct Series {
  prometheus::MetricType type = prometheus::MetricType::Untyped;
  prometheus::ClientMetric metric;
};

// Returns the series with exactly these labels.
inline std::optional<Series> FindSeries(const MetricFamilies& families, const std::string& name,
                                        const LabelMap& labels) {
  for (const prometheus::MetricFamily& family : families) {
    if (family.name != name) continue;
    for (const prometheus::ClientMetric& metric : family.metric) {
      LabelMap has;
      for (const auto& label : metric.label) has[label.name] = label.value;
      if (has == labels) return Series{family.type, metric};
    }
  }
  return std::nullopt;
}

// Returns the value of a series, or of a histogram its count of observations; nullopt if there is
// no such series.
inline std::optional<double> ValueOf(const MetricFamilies& families, const std::string& name,
                                     const LabelMap& labels = {}) {
  const std::optional<Series> series = FindSeries(families, name, labels);
  if (!series) return std::nullopt;
  if (series->type == prometheus::MetricType::Counter) return series->metric.counter.value;
  if (series->type == prometheus::MetricType::Gauge) return series->metric.gauge.value;
  return static_cast<double>(series->metric.histogram.sample_count);
}

// Returns the sum of what a histogram observed; nullopt if there is no such series.
inline std::optional<double> SumOf(const MetricFamilies& families, const std::string& name,
                                   const LabelMap& labels = {}) {
  const std::optional<Series> series = FindSeries(families, name, labels);
  if (!series) return std::nullopt;
  return series->metric.histogram.sample_sum;
}

}  // namespace corbslam::testing

#endif  // CORBSLAM_SERVICES_OBSERVE_METRICS_TESTING_METRIC_VALUES_H_
