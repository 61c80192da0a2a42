// Reads all missions' files again and again, slowly, to find damage before somebody needs what is
// damaged.
#ifndef CORBSLAM_MAP_STORE_ROCKS_JOURNAL_SCRUBBER_H_
#define CORBSLAM_MAP_STORE_ROCKS_JOURNAL_SCRUBBER_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "map_store/rocks/mission_journal.h"

namespace corbslam::map_store {

struct ScrubCounts {
  uint64_t bytes = 0;    // That were read so far.
  uint64_t rounds = 0;   // How often all missions were read.
  uint64_t damaged = 0;  // Missions that were found damaged.
  absl::Time round_ended = absl::InfinitePast();
};

// Reads one mission after the other, on a thread of its own with low priority, with a pause behind
// each piece. A mission that is damaged is said so (MissionJournal::Damage). Thread-safe.
class JournalScrubber {
 public:
  using ListMissions = std::function<std::vector<std::shared_ptr<MissionJournal>>()>;

  // Starts the thread, unless `bytes_per_s` is 0.
  JournalScrubber(ListMissions missions, uint64_t bytes_per_s);
  ~JournalScrubber();
  JournalScrubber(const JournalScrubber&) = delete;
  JournalScrubber& operator=(const JournalScrubber&) = delete;

  // Tells the thread to end soon.
  void Stop() ABSL_LOCKS_EXCLUDED(mutex_);
  ScrubCounts counts() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Reads all missions once, here and now; `pause`, called behind each piece with its bytes, says
  // whether to go on. For tests, and for the thread.
  void RunRound(const std::function<bool(uint64_t bytes)>& pause) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void Run();
  // Returns false once stopped.
  bool Pause(absl::Duration pause) ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns false if `pause` has said so.
  bool ReadMission(const MissionJournal& mission, const std::function<bool(uint64_t bytes)>& pause)
      ABSL_LOCKS_EXCLUDED(mutex_);

  const ListMissions missions_;
  const uint64_t bytes_per_s_;
  mutable absl::Mutex mutex_;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  ScrubCounts counts_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_JOURNAL_SCRUBBER_H_
