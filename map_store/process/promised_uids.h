// Remembers which uids robots were told, so that a mission of which nothing was written yet has the
// same one when it is made again.
#ifndef CORBSLAM_MAP_STORE_PROCESS_PROMISED_UIDS_H_
#define CORBSLAM_MAP_STORE_PROCESS_PROMISED_UIDS_H_

#include <deque>
#include <map>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "map_store/records/journal.h"

namespace corbslam::map_store {

// A mission goes with its last robot, or with its store's process, if nothing was written of it.
// Without this the next robot would make it with another uid, and those who know the first one
// would be taken for robots of a mission that was deleted. Remembers the last uid of as many names
// as a journal lists. Thread-safe; the journal must outlive it.
class PromisedUids {
 public:
  explicit PromisedUids(Journal& journal) : journal_(journal) {}

  // Reads what the journal lists; called before anything else.
  void Recover() ABSL_LOCKS_EXCLUDED(mutex_);
  // Remembers the uid of the name, durably when this returns. Errors are the journal's.
  absl::Status Promise(const MissionIdentity& mission) ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns the last uid that was promised of the name; "" if none was.
  std::string Find(const std::string& name) const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void Keep(const MissionIdentity& mission) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  Journal& journal_;
  absl::Mutex writing_ ABSL_ACQUIRED_BEFORE(mutex_);
  mutable absl::Mutex mutex_;
  std::map<std::string, std::string> uids_ ABSL_GUARDED_BY(mutex_);
  std::deque<MissionIdentity> in_order_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_PROCESS_PROMISED_UIDS_H_
