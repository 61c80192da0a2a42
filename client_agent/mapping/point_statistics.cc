#include "client_agent/mapping/point_statistics.h"

namespace corbslam::client_agent {

void PointStatistics::Watch(MapPointId id) {
  absl::MutexLock lock(&mutex_);
  counts_.try_emplace(id);
}

void PointStatistics::Forget(MapPointId id) {
  absl::MutexLock lock(&mutex_);
  counts_.erase(id);
}

void PointStatistics::Count(const std::vector<MapPointId>& visible,
                            const std::vector<MapPointId>& found) {
  absl::MutexLock lock(&mutex_);
  for (const MapPointId id : visible) {
    if (const auto it = counts_.find(id); it != counts_.end()) ++it->second.visible;
  }
  for (const MapPointId id : found) {
    if (const auto it = counts_.find(id); it != counts_.end()) ++it->second.found;
  }
}

double PointStatistics::FoundRatio(MapPointId id) const {
  absl::MutexLock lock(&mutex_);
  const auto it = counts_.find(id);
  return it == counts_.end() ? 1.0 : static_cast<double>(it->second.found) / it->second.visible;
}

}  // namespace corbslam::client_agent
