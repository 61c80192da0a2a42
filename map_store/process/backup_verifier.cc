#include "map_store/process/backup_verifier.h"

#include <glog/logging.h>

#include "slam/util/named_thread.h"
#include "slam/util/thread_priority.h"

namespace corbslam::map_store {
namespace {

constexpr int kVerifierStepsLower = 10;
constexpr absl::Duration kBetweenRounds = absl::Minutes(10);
// What was stored meanwhile is counted soon.
constexpr absl::Duration kFirstPause = absl::Seconds(1);

}  // namespace

void BackupVerifier::Start() {
  if (bytes_per_s_ > 0) thread_ = StartThread("backup verifier", [this] { Run(); });
}

void BackupVerifier::Stop() {
  signal_.Stop();
  if (thread_.joinable()) thread_.join();
}

void BackupVerifier::Run() {
  StepBehindRobots(kVerifierStepsLower, "comparing backups");
  const auto wait = [this](uint64_t bytes) {
    return signal_.WaitFor(
        absl::Seconds(static_cast<double>(bytes) / static_cast<double>(bytes_per_s_)));
  };
  for (absl::Duration pause = kFirstPause; signal_.WaitFor(pause); pause = kBetweenRounds) {
    RunRound(wait);
  }
}

void BackupVerifier::RunRound(const Pace& wait) {
  const auto pace = [&](uint64_t bytes) {
    {
      absl::MutexLock lock(&mutex_);
      counts_.bytes += bytes;
    }
    return wait(bytes);
  };
  const absl::Status compared = round_(pace);
  if (absl::IsCancelled(compared)) return;
  LOG_IF(WARNING, !compared.ok()) << "stored backups can't be compared: " << compared;
  absl::MutexLock lock(&mutex_);
  counts_.rounds += compared.ok() ? 1 : 0;
}

BackupVerification BackupVerifier::counts() const {
  absl::MutexLock lock(&mutex_);
  return counts_;
}

}  // namespace corbslam::map_store
