// Keeps a mission's state behind a lock, and the strand of those who change it.
#ifndef CORBSLAM_MAP_STORE_MISSION_MISSION_STRAND_H_
#define CORBSLAM_MAP_STORE_MISSION_MISSION_STRAND_H_

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "map_store/mission/memory_limit.h"
#include "map_store/options/options.h"
#include "map_store/records/journal.h"
#include "map_store/records/journal_records.h"
#include "map_store/state/mission_state.h"
#include "slam/vocabulary/vocabulary.h"

namespace corbslam::map_store {

// What a mission has from its store.
struct MissionEnvironment {
  const MapStoreOptions* options = nullptr;
  const Vocabulary* vocabulary = nullptr;
  Journal* journal = nullptr;
  std::function<absl::Time()> clock;
  // The strand calls this, without locks, when there may be something to fuse.
  std::function<void()> wake_fusion;
  bool has_worker = false;
  // Is told, with a mission's turn taken, when a mission's uid is in the journal; may be null.
  std::function<void(const std::string& mission, const std::string& uid)> note_uid;
  // Keeps the uid of a mission of which nothing is written yet, durably; may be null.
  std::function<absl::Status(const MissionIdentity& mission)> promise_uid;
  MemoryLimit* memory = nullptr;
};

// Looks at a state on its way through a replay.
using StateVisitor = std::function<absl::Status(const MissionState&)>;

// Lets writers take their turn, which they hold while the journal writes; the state's own lock is
// held only to read or to change memory, never across the journal, a worker or a listener.
// Thread-safe.
class MissionStrand {
 public:
  MissionStrand(std::string name, MissionEnvironment environment);
  MissionStrand(const MissionStrand&) = delete;
  MissionStrand& operator=(const MissionStrand&) = delete;

  const std::string& name() const { return name_; }
  const MissionEnvironment& environment() const { return environment_; }
  const MapStoreOptions& options() const { return *environment_.options; }

  // Reads what the journal has of the mission; called before anything else. DATA_LOSS names what
  // can't be read.
  absl::Status Recover() ABSL_LOCKS_EXCLUDED(mutex_);
  // Gives a mission of which nothing was written its uid, which the journal has from its first
  // record on; called before anything else, and before anybody else has the mission.
  void BeginAs(std::string uid) ABSL_LOCKS_EXCLUDED(mutex_);
  // Gives a mission that was read, and is older than uids, its own.
  void EnsureUid() ABSL_LOCKS_EXCLUDED(turn_, mutex_);
  // Writes down at once, durably, the uid that the mission began with, and so makes the mission be
  // in the journal.
  absl::Status WriteUid() ABSL_LOCKS_EXCLUDED(turn_, mutex_);
  // Sees to it that the mission keeps its uid: a robot is about to be told of it, and nothing may
  // ever have been written of the mission. Returns the errors of promise_uid.
  absl::Status PromiseUid() ABSL_LOCKS_EXCLUDED(mutex_);
  // Takes over a state from elsewhere, which the journal has already; called before anything else.
  void Restore(MissionState state) ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns what the mission was after the record at `position`, from the journal, without
  // features, and sets `position` to the last one that is there. CANCELLED once the mission is
  // deleted or `goes_on`, which is called often, says no. `visit`, if not null, is shown the
  // journal's snapshot and then the state after each record; its errors end the replay.
  absl::StatusOr<MissionState> ReplayUntil(Journal::Position& position,
                                           const std::function<bool()>& goes_on,
                                           const StateVisitor& visit = nullptr) const
      ABSL_LOCKS_EXCLUDED(mutex_);

  // Returns the lock that is the writers' turn; it is taken before the state's lock.
  absl::Mutex& turn() ABSL_LOCK_RETURNED(turn_) { return turn_; }
  absl::Mutex& mutex() const ABSL_LOCK_RETURNED(mutex_) { return mutex_; }
  // Returns the lock that a writer holds while it waits for the state's lock. Who reads in pieces
  // passes it at each pause: a read that only unlocks and locks again comes back before the writer
  // that this has woken, which then waits until another one comes.
  absl::Mutex& gate() const ABSL_LOCK_RETURNED(gate_) { return gate_; }
  const MissionState& state() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return state_; }
  MissionState& mutable_state() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    ++changes_;
    return state_;
  }
  // Returns how often somebody was about to change the state since it was read or made.
  uint64_t changes() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return changes_; }
  // Returns the state to whoever has the turn and reads much: only writers change local maps and
  // what was fused of them. Agents, queries, overlaps and the islands' flags need the lock.
  const MissionState& state_in_turn() const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(turn_) ABSL_NO_THREAD_SAFETY_ANALYSIS {
    return state_;
  }
  // Reads the state under its lock; `read` must be quick and must not call back.
  template <typename Read>
  auto WithState(Read read) const ABSL_LOCKS_EXCLUDED(mutex_) {
    absl::ReaderMutexLock lock(&mutex_);
    return read(static_cast<const MissionState&>(state_));
  }

  // Returns the number of the last revision that was committed.
  uint64_t Revision() const ABSL_LOCKS_EXCLUDED(mutex_) {
    return WithState([](const MissionState& state) { return state.global.revision; });
  }

  // How long writers held the state's lock so far, all together and the longest time.
  struct WriteTimes {
    absl::Duration total;
    absl::Duration longest;
  };
  WriteTimes write_times() const;

  // Ends all writing: from here on nothing is written any more. Whoever holds the turn sees no
  // change of it.
  void MarkDeleted() ABSL_EXCLUSIVE_LOCKS_REQUIRED(turn_) ABSL_LOCKS_EXCLUDED(mutex_);
  bool deleted() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return deleted_; }
  bool IsDeleted() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns NOT_FOUND, with the mission's name, or why robots are refused.
  absl::Status Deleted() const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  // The same, for who does not hold the lock.
  absl::Status SayDeleted() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns why a session ends with the mission: it is deleted (session_end.h), or robots are
  // refused.
  absl::Status SessionEnd() const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  // From here on robots are refused with this error: another process has the mission, or may have
  // it. OK: they are not any more.
  void Refuse(const absl::Status& why) ABSL_LOCKS_EXCLUDED(mutex_);
  const absl::Status& refusal() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return refusal_; }

  // Returns SessionEnd's error once the mission is deleted: what is deleted stays deleted.
  absl::Status Append(const JournalRecord& record) ABSL_EXCLUSIVE_LOCKS_REQUIRED(turn_);
  // Returns the position of the last record that was appended; 0: none.
  Journal::Position appended() const { return appended_; }
  // Returns whether something of the mission's journal was found damaged: nothing is appended to it
  // any more, so that work for it is in vain.
  bool IsDamaged() const { return !environment_.journal->Damage(name_).ok(); }
  // Makes all that was appended so far durable. Returns SessionEnd's error, likewise, if the
  // mission is deleted.
  absl::Status Sync() ABSL_LOCKS_EXCLUDED(turn_, mutex_);

 private:
  friend class StateWriteLock;

  void Begin(MissionState state) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status CheckNotDeleted() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Writes down the mission's uid; should that fail, the next record tries again.
  void RecordUid() ABSL_EXCLUSIVE_LOCKS_REQUIRED(turn_) ABSL_LOCKS_EXCLUDED(mutex_);

  const std::string name_;
  const MissionEnvironment environment_;

  absl::Mutex turn_ ABSL_ACQUIRED_BEFORE(gate_);
  // False: the journal has no uid yet, and is to have the state's. Only who has the turn changes
  // it, once others have the mission.
  std::atomic<bool> uid_is_recorded_ = true;
  mutable absl::Mutex gate_ ABSL_ACQUIRED_BEFORE(mutex_);
  std::atomic<Journal::Position> appended_ = 0;
  mutable absl::Mutex mutex_;
  MissionState state_ ABSL_GUARDED_BY(mutex_);
  uint64_t changes_ ABSL_GUARDED_BY(mutex_) = 0;
  bool deleted_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status refusal_ ABSL_GUARDED_BY(mutex_);
  // Only who holds the state's lock for writing changes these.
  std::atomic<int64_t> written_ns_ = 0;
  std::atomic<int64_t> longest_write_ns_ = 0;
};

// Holds the state's lock for writing, and counts how long.
class ABSL_SCOPED_LOCKABLE StateWriteLock {
 public:
  explicit StateWriteLock(MissionStrand& strand) ABSL_EXCLUSIVE_LOCK_FUNCTION(strand.mutex());
  ~StateWriteLock() ABSL_UNLOCK_FUNCTION();
  StateWriteLock(const StateWriteLock&) = delete;
  StateWriteLock& operator=(const StateWriteLock&) = delete;

 private:
  MissionStrand& strand_;
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_MISSION_STRAND_H_
