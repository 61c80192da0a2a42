// Gives back the disk that missions need no more, on a thread of its own.
#ifndef CORBSLAM_MAP_STORE_ROCKS_JOURNAL_TIDIER_H_
#define CORBSLAM_MAP_STORE_ROCKS_JOURNAL_TIDIER_H_

#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "map_store/rocks/mission_journal.h"

namespace corbslam::map_store {

// Tidies up one mission after the other (MissionJournal::Tidy), every few seconds. Thread-safe.
class JournalTidier {
 public:
  using ListMissions = std::function<std::vector<std::shared_ptr<MissionJournal>>()>;

  explicit JournalTidier(ListMissions missions);
  // Joins the thread; whoever closes the missions first has it end soon.
  ~JournalTidier();
  JournalTidier(const JournalTidier&) = delete;
  JournalTidier& operator=(const JournalTidier&) = delete;

  // Tells it that something was deleted.
  void Wake() ABSL_LOCKS_EXCLUDED(mutex_);
  // Ends the thread's work after the mission that it is at.
  void Stop() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void Run();
  // Returns false once stopped.
  bool Wait() ABSL_LOCKS_EXCLUDED(mutex_);

  const ListMissions missions_;
  absl::Mutex mutex_;
  bool woken_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_JOURNAL_TIDIER_H_
