#include "map_store/mission/memory_returner.h"

#include <cstdint>

#include "slam/util/resident_memory.h"
#include "slam/util/thread_priority.h"

namespace corbslam::map_store {
namespace {

constexpr int kPriorityStepsLower = 10;
// Who deletes one thing often deletes the next one, and streams end a moment after their mission.
constexpr absl::Duration kPause = absl::Seconds(2);
constexpr uint64_t kLeastBytes = 16 << 20;

}  // namespace

void MemoryReturner::Start() {
  thread_ = std::thread([this] { Run(); });
}

void MemoryReturner::Stop() {
  signal_.Stop();
  if (thread_.joinable()) thread_.join();
}

void MemoryReturner::Run() {
  // The allocator's locks are held meanwhile, a piece at a time.
  StepBehindRobots(kPriorityStepsLower, "giving memory back");
  for (uint64_t seen = 0; signal_.Wait(seen) && signal_.WaitFor(kPause);) give_back_();
}

void GiveBackFreeMemory() { ReturnFreeMemoryAbove(kLeastBytes); }

}  // namespace corbslam::map_store
