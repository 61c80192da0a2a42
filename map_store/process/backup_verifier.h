// Has stored backups compared with their checksums over and over, on a thread of its own.
#ifndef CORBSLAM_MAP_STORE_PROCESS_BACKUP_VERIFIER_H_
#define CORBSLAM_MAP_STORE_PROCESS_BACKUP_VERIFIER_H_

#include <cstdint>
#include <functional>
#include <thread>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "map_store/process/work_signal.h"

namespace corbslam::map_store {

struct BackupVerification {
  uint64_t bytes = 0;   // Read to compare.
  uint64_t rounds = 0;  // How often all backups were compared.
};

// Reads no more than so many bytes a second. Thread-safe.
class BackupVerifier {
 public:
  using Pace = std::function<bool(uint64_t bytes)>;
  // Compares all backups once, asking `pace` before each piece that it reads. CANCELLED: `pace`
  // said no.
  using Round = std::function<absl::Status(const Pace& pace)>;

  BackupVerifier(uint64_t bytes_per_s, Round round)
      : bytes_per_s_(bytes_per_s), round_(std::move(round)) {}
  ~BackupVerifier() { Stop(); }

  // With 0 bytes a second nothing is read.
  void Start();
  void Stop();
  // Does one round here and now, as fast as it goes.
  void RunRound() {
    RunRound([](uint64_t) { return true; });
  }
  BackupVerification counts() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void Run();
  void RunRound(const Pace& wait);

  const uint64_t bytes_per_s_;
  const Round round_;
  WorkSignal signal_;
  std::thread thread_;
  mutable absl::Mutex mutex_;
  BackupVerification counts_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_PROCESS_BACKUP_VERIFIER_H_
