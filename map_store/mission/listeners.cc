#include "map_store/mission/listeners.h"

#include <atomic>
#include <utility>

namespace corbslam::map_store {

void Listeners::SetOfSession(uint64_t session_id, Listener listener) {
  absl::MutexLock lock(&mutex_);
  if (listener == nullptr) {
    of_sessions_.erase(session_id);
  } else {
    of_sessions_[session_id] = std::move(listener);
  }
}

void Listeners::CallLast(uint64_t session_id) {
  Listener listener;
  {
    absl::MutexLock lock(&mutex_);
    const auto it = of_sessions_.find(session_id);
    if (it == of_sessions_.end()) return;
    listener = std::move(it->second);
    of_sessions_.erase(it);
  }
  listener();
}

void Listeners::Call(uint64_t session_id) const {
  Listener listener;
  {
    absl::MutexLock lock(&mutex_);
    const auto it = of_sessions_.find(session_id);
    if (it == of_sessions_.end()) return;
    listener = it->second;
  }
  listener();
}

uint64_t Listeners::AddOfMap(Listener listener) {
  static std::atomic<uint64_t> next_token = 1;
  const uint64_t token = next_token++;
  absl::MutexLock lock(&mutex_);
  of_map_[token] = std::move(listener);
  return token;
}

void Listeners::RemoveOfMap(uint64_t token) {
  absl::MutexLock lock(&mutex_);
  of_map_.erase(token);
}

bool Listeners::has_of_map() const {
  absl::MutexLock lock(&mutex_);
  return !of_map_.empty();
}

void Listeners::CallAllBut(uint64_t except_session) const {
  std::vector<Listener> listeners;
  {
    absl::MutexLock lock(&mutex_);
    for (const auto& [id, listener] : of_sessions_) {
      if (id != except_session) listeners.push_back(listener);
    }
    for (const auto& [token, listener] : of_map_) listeners.push_back(listener);
  }
  for (const Listener& listener : listeners) listener();
}

}  // namespace corbslam::map_store
