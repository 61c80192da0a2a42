#include "services/observe/metrics/disk_collector.h"

#include <filesystem>
#include <system_error>

#include "services/observe/metrics/families.h"

namespace corbslam::services {
namespace {

// Returns what is known of the disk of a folder, or of the first one above it that is there.
std::filesystem::space_info SpaceOf(const std::string& folder, std::error_code& error) {
  std::filesystem::path path = std::filesystem::absolute(folder, error);
  std::filesystem::space_info space = std::filesystem::space(path, error);
  while (error && path.has_relative_path()) {
    path = path.parent_path();
    space = std::filesystem::space(path, error);
  }
  return space;
}

}  // namespace

std::vector<prometheus::MetricFamily> DiskCollector::Collect() const {
  Families families;
  for (const WatchedFolder& folder : folders_) {
    if (folder.path.empty()) continue;
    std::error_code error;
    const std::filesystem::space_info space = SpaceOf(folder.path, error);
    if (error) continue;
    const MetricLabels labels = {{"folder", folder.name}};
    families.Gauge("corbslam_disk_free_bytes", "Room on the folder's disk for this program.",
                   static_cast<double>(space.available), labels);
    families.Gauge("corbslam_disk_size_bytes", "Size of the folder's disk.",
                   static_cast<double>(space.capacity), labels);
    families.Gauge("corbslam_disk_least_free_bytes", "With less room nothing more is written.",
                   static_cast<double>(folder.least_free_bytes), labels);
  }
  return families.Take();
}

}  // namespace corbslam::services
