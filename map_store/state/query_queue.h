// Lists which settled keyframes are to be looked up among the keyframes of which local maps.
#ifndef CORBSLAM_MAP_STORE_STATE_QUERY_QUEUE_H_
#define CORBSLAM_MAP_STORE_STATE_QUERY_QUEUE_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "absl/functional/function_ref.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// One settled keyframe that is to be looked up among the keyframes of one local map.
struct QueryTask {
  KeyframeId query;
  LocalMapId against;
  int attempts = 0;
};

// Tasks, first in, first out within each local map. A value; not thread-safe. Memory grows with the
// keyframes that wait, not with keyframes times local maps: keyframes share the list of the local
// maps to look in.
class QueryQueue {
 public:
  // So many keyframes of a local map whose owner drives on wait at most.
  static constexpr size_t kMostOfLocalMap = 256;
  // Where so many of all local maps that have ended wait, one more that ends leaves kFewestOfEnded,
  // by which it is joined.
  static constexpr size_t kMostOfEnded = 512;
  static constexpr size_t kFewestOfEnded = 16;

  QueryQueue() = default;
  // Takes the tasks as ToTasks lists them.
  explicit QueryQueue(const std::vector<QueryTask>& tasks);

  bool empty() const { return entries_.empty(); }
  // Returns the number of tasks.
  size_t size() const { return size_; }
  // The queue must not be empty.
  QueryTask front() const;
  // Returns whether ChooseOfFront has said where the first keyframe is to be looked up.
  bool IsFrontChosen() const { return front_chosen_; }
  // Returns the local maps that the first keyframe has still to be looked up in.
  std::vector<LocalMapId> AgainstOfFront() const;

  // Returns the local maps whose keyframes wait, in the order in which their first ones stand.
  std::vector<LocalMapId> WaitingLocalMaps() const;

  // Adds a task for each of the local maps.
  void Push(KeyframeId query, const std::vector<LocalMapId>& against);
  // Takes out one keyframe of the local map if more than kMostOfLocalMap of its keyframes wait: the
  // one with the nearest neighbours before and behind it, which see most of what it does. The
  // queue's first keyframe, the local map's first and its last one stay.
  void ThinOut(LocalMapId local_map);
  // The same for a local map that has ended, down to what kMostOfEnded leaves it beside the others
  // of which `has_ended` is true.
  void ThinOutEnded(LocalMapId local_map, absl::FunctionRef<bool(LocalMapId)> has_ended);
  // Makes the local map's first keyframe the queue's first, which must not be chosen. Does nothing
  // if none waits.
  void BringForward(LocalMapId local_map);
  void PopFront();
  // Keeps of the first keyframe's tasks those in these local maps, in this order; none: the
  // keyframe leaves the queue. It is not listed by ToTasks that they are chosen: who restores
  // chooses anew.
  void ChooseOfFront(const std::vector<LocalMapId>& against);
  // Counts one more failed attempt at the first task; returns how many those were.
  int CountFailureOfFront() { return ++attempts_of_front_; }
  // Takes out this task, and all of the same local map's keyframes before it, which needed no
  // answer. Does nothing if it isn't there.
  void TakeUntil(const QueryTask& task);
  void Clear();

  std::vector<QueryTask> ToTasks() const;
  // Counts the tasks by the local maps of query and candidates.
  std::map<std::pair<LocalMapId, LocalMapId>, uint64_t> CountByPair() const;

 private:
  using PlacesByLocalMap = std::map<LocalMapId, std::vector<size_t>>;
  using LocalMaps = std::shared_ptr<const std::vector<LocalMapId>>;
  struct Entry {
    KeyframeId query;
    LocalMaps against;
    size_t next =
        0;  // Index of the first of `against` that is still to be looked in; there is one.
  };

  // Returns the indices of the entries of each local map that waits.
  PlacesByLocalMap FindPlaces() const;
  // Takes out one of the entries at these indices, which are all of one local map. Returns false
  // if none of them may go.
  bool TakeNearest(const std::vector<size_t>& places);

  std::deque<Entry> entries_;
  size_t size_ = 0;
  int attempts_of_front_ = 0;
  bool front_chosen_ = false;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_QUERY_QUEUE_H_
