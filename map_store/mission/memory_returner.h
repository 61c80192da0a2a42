// Gives the memory of what was deleted back to the system, on a thread of its own.
#ifndef CORBSLAM_MAP_STORE_MISSION_MEMORY_RETURNER_H_
#define CORBSLAM_MAP_STORE_MISSION_MEMORY_RETURNER_H_

#include <functional>
#include <thread>
#include <utility>

#include "map_store/mission/work_signal.h"

namespace corbslam::map_store {

// The allocator keeps what is freed, for ever where something small lies above it. Thread-safe.
class MemoryReturner {
 public:
  // `give_back` does it; it may take a while.
  explicit MemoryReturner(std::function<void()> give_back) : give_back_(std::move(give_back)) {}
  ~MemoryReturner() { Stop(); }

  void Start();
  // Joins the thread.
  void Stop();
  // Tells the thread that much was freed.
  void Wake() { signal_.Wake(); }

 private:
  void Run();

  const std::function<void()> give_back_;
  WorkSignal signal_;
  std::thread thread_;
};

// Gives back what is free, if it is worth while.
void GiveBackFreeMemory();

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_MEMORY_RETURNER_H_
