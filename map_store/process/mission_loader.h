// Reads missions that are asleep on threads of its own, for callers that can't wait on theirs.
#ifndef CORBSLAM_MAP_STORE_PROCESS_MISSION_LOADER_H_
#define CORBSLAM_MAP_STORE_PROCESS_MISSION_LOADER_H_

#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "map_store/process/mission_directory.h"

namespace corbslam::map_store {

// Wakes one mission a thread, each once, however many wait for it. Thread-safe.
class MissionLoader {
 public:
  // Called once the mission is awake, which it stays for as long as somebody holds `awake`, or with
  // MissionDirectory::Use's error.
  using Then = std::function<void(const absl::StatusOr<std::shared_ptr<const void>>& awake)>;
  static constexpr size_t kMaxWaiting = 1000;

  // Returns the mission once it is awake, as MissionDirectory::Use does.
  using Use = std::function<absl::StatusOr<MissionDirectory::Lease>(const std::string& mission)>;

  // `directory` is not owned and must outlive it.
  MissionLoader(MissionDirectory& directory, Use use)
      : directory_(directory), use_(std::move(use)) {}
  ~MissionLoader() { Stop(); }

  void Start(int threads);
  // Ends the threads after the missions that they are at. Who still waits gets UNAVAILABLE.
  void Stop();

  // Calls `then` from another thread, or from this one if the mission is awake or there are no
  // threads; not after an error. RESOURCE_EXHAUSTED: too many wait already.
  absl::Status WhenLoaded(const std::string& mission, Then then) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void Run();
  // Takes those who wait for the mission.
  std::vector<Then> TakeWaiting(const std::string& mission) ABSL_LOCKS_EXCLUDED(mutex_);

  MissionDirectory& directory_;
  const Use use_;
  absl::Mutex mutex_;
  // Missions that no thread is at yet, and who waits for them and for those that one is at.
  std::deque<std::string> queue_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, std::vector<Then>> waiting_ ABSL_GUARDED_BY(mutex_);
  size_t waiting_count_ ABSL_GUARDED_BY(mutex_) = 0;
  bool running_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_PROCESS_MISSION_LOADER_H_
