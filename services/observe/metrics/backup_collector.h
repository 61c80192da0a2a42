// Counts backups that a map store makes by itself, and what it reads to find damage.
#ifndef CORBSLAM_SERVICES_OBSERVE_METRICS_BACKUP_COLLECTOR_H_
#define CORBSLAM_SERVICES_OBSERVE_METRICS_BACKUP_COLLECTOR_H_

#include <prometheus/collectable.h>

#include <functional>
#include <utility>
#include <vector>

#include "absl/time/time.h"
#include "map_store/process/backup_keeper.h"
#include "map_store/process/backup_verifier.h"
#include "map_store/records/backup_shelf.h"
#include "map_store/rocks/journal_scrubber.h"

namespace corbslam::services {

// Thread-safe if the functions are.
class BackupCollector : public prometheus::Collectable {
 public:
  using CountBackups = std::function<map_store::BackupCounts()>;
  using CountScrubs = std::function<map_store::ScrubCounts()>;

  struct Health {
    map_store::ShelfHealth shelf;
    map_store::BackupVerification verification;
  };
  using DescribeHealth = std::function<Health()>;

  // Any function may be null: then its numbers are 0. `every`: how often backups are made; 0:
  // never.
  BackupCollector(CountBackups backups, absl::Duration every, CountScrubs scrubs,
                  DescribeHealth health = nullptr)
      : backups_(std::move(backups)),
        every_(every),
        scrubs_(std::move(scrubs)),
        health_(std::move(health)) {}

  std::vector<prometheus::MetricFamily> Collect() const override;

 private:
  const CountBackups backups_;
  const absl::Duration every_;
  const CountScrubs scrubs_;
  const DescribeHealth health_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_METRICS_BACKUP_COLLECTOR_H_
