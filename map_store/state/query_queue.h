// Which settled keyframes are to be looked up among the keyframes of which local maps, in order.
#ifndef CORBSLAM_MAP_STORE_STATE_QUERY_QUEUE_H_
#define CORBSLAM_MAP_STORE_STATE_QUERY_QUEUE_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "slam/util/ids.h"

namespace corbslam::map_store {

// One settled keyframe to be looked up among the keyframes of one local map.
struct QueryTask {
  KeyframeId query;
  LocalMapId against;
  int attempts = 0;
};

// First in, first out. Its memory grows with the keyframes that wait, not with keyframes times
// local maps: keyframes that are looked up in the same local maps share the list of them.
class QueryQueue {
 public:
  QueryQueue() = default;
  // The tasks as ToTasks lists them.
  explicit QueryQueue(const std::vector<QueryTask>& tasks);

  bool empty() const { return entries_.empty(); }
  // The number of tasks.
  size_t size() const { return size_; }
  // The queue must not be empty.
  QueryTask front() const;

  // Adds a task for each of the local maps.
  void Push(KeyframeId query, const std::vector<LocalMapId>& against);
  void PopFront();
  // One more attempt at the first task has failed; returns how many that were.
  int CountFailureOfFront() { return ++attempts_of_front_; }
  // Takes this task out, and all before it, which needed no answer. Nothing where it isn't there.
  void TakeUntil(const QueryTask& task);
  void Clear();

  std::vector<QueryTask> ToTasks() const;
  // How many tasks wait, by the local maps of query and candidates.
  std::map<std::pair<LocalMapId, LocalMapId>, uint64_t> CountByPair() const;

 private:
  using LocalMaps = std::shared_ptr<const std::vector<LocalMapId>>;
  struct Entry {
    KeyframeId query;
    LocalMaps against;
    size_t next = 0;  // The first of them that is still to be looked at; there is one.
  };

  std::deque<Entry> entries_;
  size_t size_ = 0;
  int attempts_of_front_ = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_QUERY_QUEUE_H_
