// Looks after missions now and then, on a thread of its own.
#ifndef CORBSLAM_MAP_STORE_PROCESS_MISSION_TENDER_H_
#define CORBSLAM_MAP_STORE_PROCESS_MISSION_TENDER_H_

#include <functional>
#include <thread>
#include <utility>

#include "absl/time/time.h"
#include "map_store/process/work_signal.h"
#include "slam/util/named_thread.h"

namespace corbslam::map_store {

// Calls one function again and again. Thread-safe.
class MissionTender {
 public:
  explicit MissionTender(std::function<void()> tend, absl::Duration every = absl::Minutes(1))
      : tend_(std::move(tend)), every_(every) {}
  ~MissionTender() { Stop(); }

  // The first call is so much later.
  void Start() {
    thread_ = StartThread("mission tender", [this] {
      while (signal_.WaitFor(every_)) tend_();
    });
  }
  // Joins the thread.
  void Stop() {
    signal_.Stop();
    if (thread_.joinable()) thread_.join();
  }

 private:
  const std::function<void()> tend_;
  const absl::Duration every_;
  WorkSignal signal_;
  std::thread thread_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_PROCESS_MISSION_TENDER_H_
