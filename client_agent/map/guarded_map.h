// A local map shared by the robot's threads: many readers, one writer.
#ifndef CORBSLAM_CLIENT_AGENT_MAP_GUARDED_MAP_H_
#define CORBSLAM_CLIENT_AGENT_MAP_GUARDED_MAP_H_

#include <atomic>
#include <cstdint>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/map/map_history.h"
#include "slam/map/map.h"

namespace corbslam::client_agent {

// Any thread may read; only the mapping thread writes (others post a job to MappingQueue). Nobody
// optimises, waits or calls out while inside Read or Write, and the two never nest.
class GuardedMap {
 public:
  explicit GuardedMap(LocalMapId local_map) : local_map_(local_map), history_(local_map) {
    map_.SetObserver(&history_);
  }
  GuardedMap(const GuardedMap&) = delete;
  GuardedMap& operator=(const GuardedMap&) = delete;

  // Calls f(const Map&) under a shared lock; returns what f returns (no references into the map).
  template <typename F>
  auto Read(F&& f) const {
    absl::ReaderMutexLock lock(&mutex_);
    return std::forward<F>(f)(map_);
  }

  // Calls f(const Map&, const MapHistory&) in the same way; the history says what became of removed
  // items.
  template <typename F>
  auto ReadWithHistory(F&& f) const {
    absl::ReaderMutexLock lock(&mutex_);
    return std::forward<F>(f)(map_, history_);
  }

  // Calls f(Map&) under the exclusive lock. Mapping thread only.
  template <typename F>
  auto Write(F&& f) {
    absl::MutexLock lock(&mutex_);
    return std::forward<F>(f)(map_);
  }

  // The observer hears all further changes; it is not owned, null for none.
  void SetObserver(MapObserver* observer) {
    absl::MutexLock lock(&mutex_);
    history_.SetNext(observer);
  }

  // Returns what the map holds of its own local map: kept as it changes, not counted anew.
  OwnItems own_items() const {
    absl::ReaderMutexLock lock(&mutex_);
    return history_.own_items();
  }

  LocalMapId local_map() const { return local_map_; }
  bool IsOwn(KeyframeId id) const { return id.local_map == local_map_; }
  bool IsOwn(MapPointId id) const { return id.local_map == local_map_; }

  // Return ids that are never the same twice. Thread-safe; tracking numbers keyframes, mapping
  // points.
  KeyframeId NewKeyframeId() { return {local_map_, next_keyframe_.fetch_add(1)}; }
  MapPointId NewPointId() { return {local_map_, next_point_.fetch_add(1)}; }
  // The map goes on where an earlier process ended, which gave ids below these.
  void GoOnFrom(uint32_t next_keyframe, uint32_t next_point) {
    next_keyframe_ = next_keyframe;
    next_point_ = next_point;
  }

  // Returns how often the robot's own map was moved as a whole. It is counted inside Write, so that
  // a reader that finds no difference has read one map before and after.
  uint64_t corrections() const { return corrections_.load(); }
  void CountCorrection() { corrections_.fetch_add(1); }

 private:
  const LocalMapId local_map_;
  std::atomic<uint32_t> next_keyframe_ = 0;
  std::atomic<uint32_t> next_point_ = 0;
  std::atomic<uint64_t> corrections_ = 0;

  mutable absl::Mutex mutex_;
  MapHistory history_ ABSL_GUARDED_BY(mutex_);
  Map map_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_MAP_GUARDED_MAP_H_
