// Has backups of all missions made again and again, on a thread of its own.
#ifndef CORBSLAM_MAP_STORE_PROCESS_BACKUP_KEEPER_H_
#define CORBSLAM_MAP_STORE_PROCESS_BACKUP_KEEPER_H_

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "map_store/process/work_signal.h"

namespace corbslam::map_store {

struct BackupCounts {
  uint64_t made = 0;
  uint64_t unchanged = 0;  // Missions that needed none, once a round each.
  uint64_t failed = 0;
  // Missions whose last attempt failed, and why.
  std::map<std::string, std::string> failing;
  // When all missions had a backup that was up to date; InfinitePast: not yet.
  absl::Time all_safe_at = absl::InfinitePast();
};

// Makes one backup at a time. An error is that mission's alone, and tried again in the next round.
// Thread-safe.
class BackupKeeper {
 public:
  using ListMissions = std::function<absl::StatusOr<std::vector<std::string>>()>;
  // Makes a backup of the mission, if it needs one; returns whether.
  using BackUp = std::function<absl::StatusOr<bool>(const std::string& mission)>;

  // A round begins each `every`, the first one at once.
  BackupKeeper(absl::Duration every, std::function<absl::Time()> clock, ListMissions missions,
               BackUp back_up);
  ~BackupKeeper() { Stop(); }
  BackupKeeper(const BackupKeeper&) = delete;
  BackupKeeper& operator=(const BackupKeeper&) = delete;

  void Start();
  // Ends the thread once the backup that is being made is there.
  void Stop();
  // Does a round, if one is due. Returns when the next one is.
  absl::Time RunIfDue() ABSL_LOCKS_EXCLUDED(mutex_);
  BackupCounts counts() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void Run();
  // Returns whether the mission's backup is up to date.
  bool KeepMission(const std::string& mission) ABSL_LOCKS_EXCLUDED(mutex_);
  void NoteFailure(const std::string& mission, const absl::Status& status)
      ABSL_LOCKS_EXCLUDED(mutex_);

  const absl::Duration every_;
  const std::function<absl::Time()> clock_;
  const ListMissions missions_;
  const BackUp back_up_;
  WorkSignal signal_;
  std::thread thread_;
  mutable absl::Mutex mutex_;
  absl::Time due_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  BackupCounts counts_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_PROCESS_BACKUP_KEEPER_H_
