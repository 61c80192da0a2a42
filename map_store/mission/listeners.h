// Keeps who wants to hear that a mission has changed.
#ifndef CORBSLAM_MAP_STORE_MISSION_LISTENERS_H_
#define CORBSLAM_MAP_STORE_MISSION_LISTENERS_H_

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace corbslam::map_store {

// Calls listeners without its lock, and without any other lock of the store. Thread-safe.
class Listeners {
 public:
  using Listener = std::function<void()>;

  // Replaces the session's listener; null takes it away.
  void SetOfSession(uint64_t session_id, Listener listener);
  // Calls the session's listener for the last time, if there is one.
  void CallLast(uint64_t session_id);
  // Calls the session's listener, if there is one.
  void Call(uint64_t session_id) const;

  // Returns a token that no other mission has: another mission may have got the name when the
  // listener is removed.
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
