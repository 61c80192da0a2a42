#include "map_store/state/pose_table.h"

#include <utility>

#include "slam/util/heap_bytes.h"

namespace corbslam::map_store {

PoseTables& PoseTables::operator=(const PoseTables& other) {
  if (this != &other) Clear();
  return *this;
}

PoseTables& PoseTables::operator=(PoseTables&& other) noexcept {
  if (this != &other) Clear();
  return *this;
}

std::shared_ptr<const PoseTable> PoseTables::Find(LocalMapId local_map) const {
  absl::MutexLock lock(&mutex_);
  const auto it = tables_.find(local_map);
  return it == tables_.end() ? nullptr : it->second;
}

void PoseTables::Add(LocalMapId local_map, std::shared_ptr<const PoseTable> table) const {
  absl::MutexLock lock(&mutex_);
  // The old table is freed outside the lock, by whoever still reads it or by the caller.
  std::swap(tables_[local_map], table);
  if (tables_[local_map] == nullptr) tables_.erase(local_map);
}

uint64_t PoseTables::HeapBytes() const {
  absl::MutexLock lock(&mutex_);
  uint64_t bytes = TreeBytes<decltype(tables_)::value_type>(tables_.size());
  for (const auto& [id, table] : tables_) {
    bytes += HeapBlockBytes(sizeof(PoseTable)) + VectorBytes(table->standings) +
             TreeBytes<IslandPoses::value_type>(table->poses.size());
  }
  return bytes;
}

void PoseTables::Clear() {
  absl::MutexLock lock(&mutex_);
  tables_.clear();
}

}  // namespace corbslam::map_store
