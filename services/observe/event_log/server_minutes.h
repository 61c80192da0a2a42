// Says in a line how a server fares: what is wrong first, then what it holds and does.
#ifndef CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_SERVER_MINUTES_H_
#define CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_SERVER_MINUTES_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/time/time.h"

namespace corbslam::services {

// Returns bytes for people, such as "1.5 MiB" or "20.0 GiB".
std::string FormatBytes(uint64_t bytes);

struct StoreMinute {
  // Why the store takes nothing in; OK: it does.
  absl::Status writable;
  size_t damaged_missions = 0;
  // Fusion workers; without any nothing is fused.
  bool has_worker = true;
  // For how long none has taken a request, and why; nullopt: they do.
  struct Outage {
    absl::Duration lasts;
    std::string cause;
  };
  std::optional<Outage> outage;
  // Batches that were refused for want of memory since the last line.
  uint64_t refused = 0;

  size_t robots = 0;  // With a session now.
  size_t missions = 0;
  size_t keyframes = 0;
  int64_t new_keyframes = 0;    // Since the last line; negative after a deletion.
  size_t waiting_requests = 0;  // To fusion workers.
  uint64_t rss_bytes = 0;
  uint64_t memory_budget_bytes = 0;  // 0: there is none.
  // Of the missions on the disk, and what that has left; nullopt: missions are in memory alone.
  struct Disk {
    uint64_t used_bytes = 0;
    uint64_t free_bytes = 0;
  };
  std::optional<Disk> disk;
};

struct WorkerMinute {
  int held = 0;            // Requests that are received, worked on or wait.
  size_t waiting = 0;      // Of them those that no thread has begun with.
  uint64_t done = 0;       // Since the last line.
  uint64_t failed = 0;     // Further ones, likewise.
  uint64_t cancelled = 0;  // Further ones, likewise: the store did not want them any more.
  double cpu_s = 0;        // Processor time since the last line.
  absl::Duration took;     // Since the last line.
  uint64_t rss_bytes = 0;
};

struct ViewerMinute {
  // False while the map store can't be reached.
  bool store_answers = true;
  size_t pages = 0;     // Open ones.
  size_t missions = 0;  // That they follow.
  uint64_t rss_bytes = 0;
};

std::string FormatMinute(const StoreMinute& minute);
std::string FormatMinute(const WorkerMinute& minute);
std::string FormatMinute(const ViewerMinute& minute);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_EVENT_LOG_SERVER_MINUTES_H_
