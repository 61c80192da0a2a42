// Who wants to hear that a mission has changed.
#ifndef CORBSLAM_MAP_STORE_MISSION_LISTENERS_H_
#define CORBSLAM_MAP_STORE_MISSION_LISTENERS_H_

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace corbslam::map_store {

// Thread-safe. Listeners are called without its lock, and without any other of the store's.
class Listeners {
 public:
  using Listener = std::function<void()>;

  // Takes the place of the session's listener; null takes it away.
  void SetOfSession(uint64_t session_id, Listener listener);
  // Calls it for the last time. Nothing where there is none.
  void CallLast(uint64_t session_id);
  // Nothing where there is none.
  void Call(uint64_t session_id) const;

  // The token is no other mission's: another one may have got the name when it is removed.
  uint64_t AddOfMap(Listener listener);
  void RemoveOfMap(uint64_t token);
  bool has_of_map() const;

  void CallAllBut(uint64_t except_session) const;

 private:
  mutable absl::Mutex mutex_;
  std::map<uint64_t, Listener> of_sessions_ ABSL_GUARDED_BY(mutex_);
  std::map<uint64_t, Listener> of_map_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_LISTENERS_H_
