// Remembers what happened in a mission lately, and logs what people watch for.
#ifndef CORBSLAM_MAP_STORE_MISSION_EVENT_BOOK_H_
#define CORBSLAM_MAP_STORE_MISSION_EVENT_BOOK_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "map_store/mission/listeners.h"
#include "map_store/state/mission_event.h"

namespace corbslam::map_store {

// Keeps the newest events. Noting and telling are two steps, so that events can be noted in
// the order of the changes, by writers who have the turn, and told without any lock. Thread-safe.
class EventBook {
 public:
  // How many events are remembered.
  static constexpr size_t kMaxEvents = 1000;

  explicit EventBook(std::function<absl::Time()> clock, std::string mission = "")
      : clock_(std::move(clock)), mission_(std::move(mission)) {}

  // Remembers the end of a book whose mission is asleep.
  struct Past {
    uint64_t last_number = 0;
    std::deque<MissionEvent> events;
  };
  // How many events that are.
  static constexpr size_t kMaxEventsAsleep = 100;

  Past GetPast() const;
  // Goes on from there; called before all else.
  void GoOnFrom(Past past);

  // Notes what has happened; `revision` is the mission's then. It costs next to nothing, and waits
  // for nobody.
  void Note(uint64_t revision, MissionEvent::What what);
  // Logs what was noted since the last call (event_lines.h), and calls the listeners if that is
  // anything. The caller holds no lock.
  void Tell();

  // Returns the first event after `number` that is remembered, which also says how many before it
  // were forgotten; none if nothing has happened since. A number of 0, or one newer than the
  // newest, which is of an earlier life of the store, means from the oldest on.
  std::optional<MissionEvent> After(uint64_t number) const;

  // Those who listen are called as listeners of the map (Listeners::AddOfMap).
  Listeners& listeners() { return listeners_; }
  const Listeners& listeners() const { return listeners_; }

 private:
  const std::function<absl::Time()> clock_;
  const std::string mission_;
  Listeners listeners_;
  std::atomic<bool> untold_ = false;
  mutable absl::Mutex mutex_;
  uint64_t last_number_ ABSL_GUARDED_BY(mutex_) = 0;
  std::deque<MissionEvent> events_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::string> unlogged_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_EVENT_BOOK_H_
