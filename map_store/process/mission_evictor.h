// Lets missions that nobody uses leave memory.
#ifndef CORBSLAM_MAP_STORE_PROCESS_MISSION_EVICTOR_H_
#define CORBSLAM_MAP_STORE_PROCESS_MISSION_EVICTOR_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <thread>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "map_store/process/memory_budget.h"
#include "map_store/process/mission_directory.h"
#include "map_store/process/work_signal.h"
#include "map_store/records/journal.h"

namespace corbslam::map_store {

// Evicts missions, which are asleep then, one at a time: what only memory has of one becomes a
// snapshot while everybody can still use it, and only then whoever wants it waits, until its
// database is closed. Thread-safe.
class MissionEvictor {
 public:
  // The arguments are not owned and must outlive it. A mission falls asleep when nobody has used it
  // for `sleep_after`; infinite: only when somebody asks for it, or memory is short.
  MissionEvictor(MissionDirectory& directory, Journal& journal, MemoryBudget& memory,
                 std::function<absl::Time()> clock, absl::Duration sleep_after)
      : directory_(directory),
        journal_(journal),
        memory_(memory),
        clock_(std::move(clock)),
        sleep_after_(sleep_after) {}
  ~MissionEvictor() { Stop(); }

  // Starts the thread that looks once a second.
  void Start();
  // Gives up what is under way, and joins the thread.
  void Stop();

  // Puts this mission to sleep, if it is not asleep already. FAILED_PRECONDITION, with the reason,
  // where it has to stay in memory.
  absl::Status Evict(absl::string_view name);
  // Puts those to sleep whose time has come. Returns how many fell asleep.
  size_t EvictUnused();
  // Puts the mission to sleep that has not been used for longest, of those that may sleep; in
  // haste, because somebody waits, without tidying up its files, and even if it was used a moment
  // ago. Returns false if there is none.
  bool MakeRoom(bool in_haste);
  // Writes summaries of all missions that may sleep, so that the next start need not read them. The
  // store ends: nobody uses it any more. Missions that need a snapshot first are left out once
  // `time_left` is over.
  void EvictAll(absl::Duration time_left);

  // Returns how often a mission has fallen asleep.
  uint64_t evictions() const { return evictions_; }

 private:
  using Unused = MissionDirectory::Unused;

  void Run();
  absl::Status TryEvict(const Unused& unused, bool in_haste, const std::function<bool()>& goes_on)
      ABSL_LOCKS_EXCLUDED(evicting_);
  // The mission is retired: it can only fall asleep now.
  void PutAside(const Unused& unused) ABSL_EXCLUSIVE_LOCKS_REQUIRED(evicting_);
  // Returns whether an attempt that failed is to be made again so soon.
  bool MayTry(const Unused& unused) ABSL_LOCKS_EXCLUDED(tries_mutex_);
  void NoteFailure(const Unused& unused, const absl::Status& status)
      ABSL_LOCKS_EXCLUDED(tries_mutex_);

  MissionDirectory& directory_;
  Journal& journal_;
  MemoryBudget& memory_;
  const std::function<absl::Time()> clock_;
  const absl::Duration sleep_after_;
  std::atomic<uint64_t> evictions_ = 0;
  // Held while a mission falls asleep.
  absl::Mutex evicting_;
  absl::Mutex tries_mutex_;
  // Missions whose snapshot could not be written, and when to try again.
  std::map<std::string, absl::Time> next_try_ ABSL_GUARDED_BY(tries_mutex_);
  WorkSignal signal_;
  std::thread thread_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_PROCESS_MISSION_EVICTOR_H_
