#include "services/observe/metrics/backup_collector.h"

#include <cstdint>

#include "services/observe/metrics/families.h"

namespace corbslam::services {

using map_store::BackupCounts;
using map_store::ScrubCounts;

namespace {

double UnixSeconds(absl::Time time) {
  return time == absl::InfinitePast() ? 0 : absl::ToDoubleSeconds(time - absl::UnixEpoch());
}

void AddBackups(const BackupCounts& counts, absl::Duration every, Families& families) {
  const auto outcome = [&families](const char* name, uint64_t value) {
    families.Counter("corbslam_backups_total",
                     "Looks at missions for a stored backup, by what came of them.",
                     static_cast<double>(value), {{"outcome", name}});
  };
  outcome("made", counts.made);
  outcome("unchanged", counts.unchanged);
  outcome("failed", counts.failed);
  families.Gauge("corbslam_backups_failing", "Missions whose last stored backup failed.",
                 static_cast<double>(counts.failing.size()));
  families.Gauge("corbslam_backups_safe_time_seconds",
                 "When last all missions had a stored backup that was up to date, seconds since "
                 "1970; 0: not yet.",
                 UnixSeconds(counts.all_safe_at));
  families.Gauge("corbslam_backups_interval_seconds", "How often backups are stored; 0: never.",
                 absl::ToDoubleSeconds(every));
}

void AddHealth(const BackupCollector::Health& health, Families& families) {
  families.Gauge("corbslam_backups_damaged", "Stored backups that are known to be damaged.",
                 static_cast<double>(health.shelf.damaged));
  families.Gauge("corbslam_backups_unverified",
                 "Stored backups that were not compared with their checksums yet.",
                 static_cast<double>(health.shelf.unverified));
  families.Gauge("corbslam_backups_verified_time_seconds",
                 "When the stored backup was compared with its checksums that was compared longest "
                 "ago, seconds since 1970; 0: none was.",
                 UnixSeconds(health.shelf.oldest_verified));
  families.Counter("corbslam_backups_verified_bytes_total",
                   "Bytes of stored backups that were read again to find damage.",
                   static_cast<double>(health.verification.bytes));
  families.Counter("corbslam_backups_verify_rounds_total",
                   "How often all stored backups were read so.",
                   static_cast<double>(health.verification.rounds));
}

void AddScrubs(const ScrubCounts& counts, Families& families) {
  families.Counter("corbslam_scrubbed_bytes_total",
                   "Bytes of missions that were read again to find damage.",
                   static_cast<double>(counts.bytes));
  families.Counter("corbslam_scrub_rounds_total", "How often all missions were read so.",
                   static_cast<double>(counts.rounds));
  families.Counter("corbslam_scrub_damaged_total", "Missions that were found damaged so.",
                   static_cast<double>(counts.damaged));
}

}  // namespace

std::vector<prometheus::MetricFamily> BackupCollector::Collect() const {
  Families families;
  AddBackups(backups_ != nullptr ? backups_() : BackupCounts(), every_, families);
  AddHealth(health_ != nullptr ? health_() : Health(), families);
  AddScrubs(scrubs_ != nullptr ? scrubs_() : ScrubCounts(), families);
  return families.Take();
}

}  // namespace corbslam::services
