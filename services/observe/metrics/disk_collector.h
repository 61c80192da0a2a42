// Says how much room there is on the disks that a program writes to.
#ifndef CORBSLAM_SERVICES_OBSERVE_METRICS_DISK_COLLECTOR_H_
#define CORBSLAM_SERVICES_OBSERVE_METRICS_DISK_COLLECTOR_H_

#include <prometheus/collectable.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace corbslam::services {

struct WatchedFolder {
  std::string name;  // "journal", "backups", "spool" or "recordings".
  std::string path;  // Empty: there is none.
  // With less room nothing more is written.
  uint64_t least_free_bytes = 0;
};

// Asks the system when somebody asks it. Thread-safe.
class DiskCollector : public prometheus::Collectable {
 public:
  explicit DiskCollector(std::vector<WatchedFolder> folders) : folders_(std::move(folders)) {}

  std::vector<prometheus::MetricFamily> Collect() const override;

 private:
  const std::vector<WatchedFolder> folders_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_METRICS_DISK_COLLECTOR_H_
