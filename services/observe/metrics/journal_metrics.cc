#include "services/observe/metrics/journal_metrics.h"

#include <string>
#include <variant>

#include "services/observe/metrics/buckets.h"

namespace corbslam::services {
namespace {

prometheus::Labels OperationLabel(const std::string& name) { return {{"operation", name}}; }

prometheus::Histogram& LongHistogram(const std::string& name, const std::string& help,
                                     prometheus::Registry& registry) {
  return prometheus::BuildHistogram().Name(name).Help(help).Register(registry).Add({},
                                                                                   LongTimes_s());
}

}  // namespace

void JournalMetrics::Operation::Note(absl::Duration took, const absl::Status& status) {
  duration.Observe(absl::ToDoubleSeconds(took));
  if (!status.ok()) errors.Increment();
}

JournalMetrics::JournalMetrics(prometheus::Registry& registry)
    : durations_(prometheus::BuildHistogram()
                     .Name("corbslam_journal_duration_seconds")
                     .Help("What the journal's writes take: append, sync, snapshot.")
                     .Register(registry)),
      errors_(prometheus::BuildCounter()
                  .Name("corbslam_journal_errors_total")
                  .Help("Writes of the journal that failed.")
                  .Register(registry)),
      append_{durations_.Add(OperationLabel("append"), ShortTimes_s()),
              errors_.Add(OperationLabel("append"))},
      sync_{durations_.Add(OperationLabel("sync"), ShortTimes_s()),
            errors_.Add(OperationLabel("sync"))},
      snapshot_{durations_.Add(OperationLabel("snapshot"), ShortTimes_s()),
                errors_.Add(OperationLabel("snapshot"))},
      writable_(prometheus::BuildGauge()
                    .Name("corbslam_journal_writable")
                    .Help("Whether the journal takes records, as of the last second.")
                    .Register(registry)
                    .Add({})),
      merges_(LongHistogram("corbslam_merge_duration_seconds",
                            "From the verified overlap of two islands to their being one.",
                            registry)),
      adjustments_(LongHistogram("corbslam_global_adjustment_duration_seconds",
                                 "What committed global bundle adjustments took the worker.",
                                 registry)) {}

void JournalMetrics::OnAppended(absl::string_view, const map_store::JournalRecord& record,
                                absl::Duration took, const absl::Status& status) {
  append_.Note(took, status);
  if (!status.ok()) return;
  const auto* fuse = std::get_if<map_store::FuseRecord>(&record);
  if (fuse != nullptr && fuse->plan.source.IsValid()) merges_.Observe(fuse->merge_ms * 1e-3);
  const auto* adjust = std::get_if<map_store::AdjustRecord>(&record);
  if (adjust != nullptr) adjustments_.Observe(adjust->statistics.ms * 1e-3);
}

void JournalMetrics::OnSynced(absl::Duration took, const absl::Status& status) {
  sync_.Note(took, status);
}

void JournalMetrics::OnSnapshot(absl::Duration took, const absl::Status& status) {
  snapshot_.Note(took, status);
}

void JournalMetrics::OnChecked(const absl::Status& writable) { writable_.Set(writable.ok()); }

}  // namespace corbslam::services
