// Counts and times the journal, and what fusion commits to it, as metrics.
#ifndef CORBSLAM_SERVICES_OBSERVE_METRICS_JOURNAL_METRICS_H_
#define CORBSLAM_SERVICES_OBSERVE_METRICS_JOURNAL_METRICS_H_

#include <prometheus/counter.h>
#include <prometheus/family.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include "services/observe/observed_journal.h"

namespace corbslam::services {

// Listens to one journal. Thread-safe.
class JournalMetrics : public JournalObserver {
 public:
  // `registry` is not owned and must outlive it.
  explicit JournalMetrics(prometheus::Registry& registry);

  void OnAppended(absl::string_view mission, const map_store::JournalRecord& record,
                  absl::Duration took, const absl::Status& status) override;
  void OnSynced(absl::Duration took, const absl::Status& status) override;
  void OnSnapshot(absl::Duration took, const absl::Status& status) override;
  void OnChecked(const absl::Status& writable) override;

 private:
  // Metrics of one kind of write.
  struct Operation {
    prometheus::Histogram& duration;
    prometheus::Counter& errors;
    void Note(absl::Duration took, const absl::Status& status);
  };

  prometheus::Family<prometheus::Histogram>& durations_;
  prometheus::Family<prometheus::Counter>& errors_;
  Operation append_;
  Operation sync_;
  Operation snapshot_;
  prometheus::Gauge& writable_;
  prometheus::Histogram& merges_;
  prometheus::Histogram& adjustments_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_METRICS_JOURNAL_METRICS_H_
