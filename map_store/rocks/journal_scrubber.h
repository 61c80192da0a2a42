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
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "map_store/rocks/log_file_check.h"
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
  using MissionPtr = std::shared_ptr<MissionJournal>;
  // How it gets at missions; all may be called from the thread.
  struct Access {
    std::function<std::vector<MissionPtr>()> list_open;
    // Missions that nobody has open, by their names.
    std::function<std::vector<std::string>()> list_closed;
    // Looks at the files of such a mission and opens it, to read it only; null: that is not to be
    // done now. DATA_LOSS: it is damaged.
    std::function<absl::StatusOr<MissionPtr>(const std::string& name, const ReadPace& pace)>
        open_closed;
    // Returns whether it is closed still.
    std::function<bool(const std::string& name)> is_closed;
    // Remembers what is wrong with it; false: it was opened meanwhile, and may have changed.
    std::function<bool(const std::string& name, const absl::Status& damage)> note_closed;
  };

  // Starts the thread, unless `bytes_per_s` is 0.
  JournalScrubber(Access access, uint64_t bytes_per_s);
  ~JournalScrubber();
  JournalScrubber(const JournalScrubber&) = delete;
  JournalScrubber& operator=(const JournalScrubber&) = delete;

  // Tells the thread to end soon.
  void Stop() ABSL_LOCKS_EXCLUDED(mutex_);
  ScrubCounts counts() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Reads all missions once, here and now; `pause`, called behind each piece with its bytes, says
  // whether to go on. For tests, and for the thread.
  void RunRound(const ReadPace& pause) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void Run();
  // Returns false once stopped.
  bool Pause(absl::Duration pause) ABSL_LOCKS_EXCLUDED(mutex_);
  // Return CANCELLED if `pause` has said so.
  absl::Status ReadMission(const MissionJournal& mission, const ReadPace& pause)
      ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status ReadClosed(const std::string& name, const ReadPace& pause)
      ABSL_LOCKS_EXCLUDED(mutex_);
  void Count(const std::string& name, const absl::Status& damage) ABSL_LOCKS_EXCLUDED(mutex_);

  const Access access_;
  const uint64_t bytes_per_s_;
  mutable absl::Mutex mutex_;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  ScrubCounts counts_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_JOURNAL_SCRUBBER_H_
