#include "map_store/process/backup_keeper.h"

#include <glog/logging.h>

#include <algorithm>
#include <iterator>
#include <set>

#include "slam/util/named_thread.h"
#include "slam/util/thread_priority.h"

namespace corbslam::map_store {
namespace {

constexpr int kBackupStepsLower = 10;
// The clock may be set while the thread waits.
constexpr absl::Duration kLongestWait = absl::Minutes(1);

}  // namespace

BackupKeeper::BackupKeeper(absl::Duration every, std::function<absl::Time()> clock,
                           ListMissions missions, BackUp back_up)
    : every_(every),
      clock_(std::move(clock)),
      missions_(std::move(missions)),
      back_up_(std::move(back_up)) {}

void BackupKeeper::Start() {
  thread_ = StartThread("backup keeper", [this] { Run(); });
}

void BackupKeeper::Stop() {
  signal_.Stop();
  if (thread_.joinable()) thread_.join();
}

void BackupKeeper::Run() {
  StepBehindRobots(kBackupStepsLower, "backups");
  absl::Duration pause = absl::ZeroDuration();
  while (signal_.WaitFor(pause)) {
    const absl::Time due = RunIfDue();
    pause = std::clamp(due - clock_(), absl::ZeroDuration(), kLongestWait);
  }
}

absl::Time BackupKeeper::RunIfDue() {
  const absl::Time begin = clock_();
  {
    absl::MutexLock lock(&mutex_);
    // A clock that was set back doesn't put backups off.
    if (begin < due_ && due_ <= begin + every_) return due_;
    due_ = begin + every_;
  }
  const absl::StatusOr<std::vector<std::string>> missions = missions_();
  if (!missions.ok()) NoteFailure("", missions.status());
  bool all_safe = missions.ok();
  for (const std::string& mission : missions.value_or(std::vector<std::string>())) {
    if (signal_.stopped()) return begin + every_;
    all_safe &= KeepMission(mission);
  }
  absl::MutexLock lock(&mutex_);
  if (all_safe) counts_.all_safe_at = begin;
  if (missions.ok()) {
    // Of those that are no more nobody wants to know.
    const std::set<std::string> there(missions->begin(), missions->end());
    std::erase_if(counts_.failing,
                  [&there](const auto& failing) { return !there.contains(failing.first); });
  }
  return due_;
}

bool BackupKeeper::KeepMission(const std::string& mission) {
  const absl::StatusOr<bool> made = back_up_(mission);
  // It was deleted, or put to sleep, between the list and the backup.
  if (absl::IsNotFound(made.status()) || absl::IsAborted(made.status())) return true;
  if (!made.ok()) {
    NoteFailure(mission, made.status());
    return false;
  }
  absl::MutexLock lock(&mutex_);
  ++(*made ? counts_.made : counts_.unchanged);
  counts_.failing.erase(mission);
  return true;
}

void BackupKeeper::NoteFailure(const std::string& mission, const absl::Status& status) {
  LOG(ERROR) << "no backup of " << (mission.empty() ? "the missions" : "mission " + mission)
             << ", it is tried again in " << absl::FormatDuration(every_) << ": " << status;
  absl::MutexLock lock(&mutex_);
  ++counts_.failed;
  counts_.failing[mission] = std::string(status.message());
}

BackupCounts BackupKeeper::counts() const {
  absl::MutexLock lock(&mutex_);
  return counts_;
}

}  // namespace corbslam::map_store
