// Makes what the spool wrote survive a loss of power, on a thread of its own: neither tracking nor
// the link waits for the disk.
#ifndef CORBSLAM_CLIENT_AGENT_SPOOL_SPOOL_SYNCER_H_
#define CORBSLAM_CLIENT_AGENT_SPOOL_SPOOL_SYNCER_H_

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "client_agent/spool/spool_files.h"

namespace corbslam::client_agent {

struct SyncPolicy {
  // The oldest write waits no longer than this.
  absl::Duration after = absl::Seconds(1);
  // When so many bytes wait, they are synced at once.
  uint64_t bytes = 1 << 20;
};

// Thread-safe. Writes are numbered 1, 2, 3, ... over all files.
class SpoolSyncer {
 public:
  // `files` is not owned.
  SpoolSyncer(SpoolFiles* files, const SyncPolicy& policy);
  // Ends the thread; what was not synced stays so.
  ~SpoolSyncer();
  SpoolSyncer(const SpoolSyncer&) = delete;
  SpoolSyncer& operator=(const SpoolSyncer&) = delete;

  // Notes write `number` of so many bytes to the end of a file.
  void NoteWrite(const std::string& file, uint64_t number, uint64_t bytes);
  // The file is gone: nothing of it is to be kept.
  void Forget(const std::string& file);

  // Has all that was written synced at once, without waiting for it.
  void Hurry();
  // Waits until all that was written is on the disk. Returns the error where it can't be, as
  // TakeError does.
  absl::Status SyncNow();

  // Returns the last write that is on the disk with all before it.
  uint64_t synced() const;
  // Returns why the disk did not keep what was written after `synced`, once: it is to be written
  // again, into another file. Nothing is synced before it is taken.
  absl::Status TakeError();
  // Returns how often the disk was made to keep something.
  uint64_t syncs() const;

 private:
  using Files = std::map<std::string, uint64_t>;
  void Run();
  // Returns the files that are due now; empty: stop.
  Files WaitForWork() ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status SyncFiles(const Files& files) ABSL_LOCKS_EXCLUDED(mutex_);
  void NoteSynced(const Files& files, absl::Status synced) ABSL_LOCKS_EXCLUDED(mutex_);
  bool HasWork() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return error_.ok() && !unsynced_.empty();
  }
  bool IsUrgent() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool IsSettled() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  SpoolFiles* const files_;
  const SyncPolicy policy_;
  mutable absl::Mutex mutex_;
  // Files with writes that are not synced, and the number of the last one.
  Files unsynced_ ABSL_GUARDED_BY(mutex_);
  uint64_t unsynced_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Time oldest_ ABSL_GUARDED_BY(mutex_) = absl::InfiniteFuture();
  uint64_t written_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t synced_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t syncs_ ABSL_GUARDED_BY(mutex_) = 0;
  bool hurried_ ABSL_GUARDED_BY(mutex_) = false;
  // Files that are being synced and are not gone meanwhile.
  std::set<std::string> syncing_ ABSL_GUARDED_BY(mutex_);
  bool is_syncing_ ABSL_GUARDED_BY(mutex_) = false;
  bool stop_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status error_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SPOOL_SPOOL_SYNCER_H_
