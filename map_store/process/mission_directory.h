// Knows all missions of a store by their names: those in memory and who uses them, those asleep,
// and those that could not be read.
#ifndef CORBSLAM_MAP_STORE_PROCESS_MISSION_DIRECTORY_H_
#define CORBSLAM_MAP_STORE_PROCESS_MISSION_DIRECTORY_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "map_store/mission/event_book.h"
#include "map_store/mission/mission_summary.h"
#include "map_store/process/mission.h"

namespace corbslam::map_store {

// A mission that is on the disk alone.
struct EvictedMission {
  MissionSummary summary;
  EventBook::Past events;

  // Says of the summary what holds from now on: nobody is in the mission, and it takes no memory.
  void NoteEvicted(uint64_t disk_bytes);
};

// What there is of one mission: it is in memory, asleep or damaged.
struct KnownMission {
  std::string name;
  std::shared_ptr<Mission> mission;
  std::shared_ptr<const EvictedMission> evicted;
  absl::Status damage;
  absl::Time last_used;
  bool is_used = false;  // Somebody holds a lease.
};

// Hands out missions and keeps count of their users: who holds a lease has the mission stay in
// memory. No lock is held while a mission is read, so that only those who want this one wait. A
// mission's own locks are taken after this one's. Thread-safe; leases must not outlive it.
class MissionDirectory {
 public:
  using Lease = std::shared_ptr<Mission>;
  // Reads a mission that sleeps. DATA_LOSS: it is damaged, and stays so; after other errors it
  // sleeps on.
  using Load = std::function<absl::StatusOr<std::shared_ptr<Mission>>(
      const std::string& name, const EvictedMission& evicted)>;
  struct Counts {
    size_t in_memory =
        0;  // Those on their way there or back, and those damaged or being made, too.
    size_t asleep = 0;
  };
  using Make = absl::FunctionRef<absl::StatusOr<std::shared_ptr<Mission>>(const Counts&)>;

  // What becomes of missions that leave memory.
  enum class Asleep {
    kRemembered,
    kForgotten,  // They may be another process's the next time: the caller adds them again.
  };

  // `clock` says when a mission was used.
  MissionDirectory(std::function<absl::Time()> clock, Load load,
                   Asleep asleep = Asleep::kRemembered)
      : clock_(std::move(clock)), load_(std::move(load)), asleep_(asleep) {}

  // Users.

  // Returns the mission. One that sleeps is read, on the thread of its first user; the others wait
  // for that. NOT_FOUND: there is none; DATA_LOSS: it can't be read.
  absl::StatusOr<Lease> Use(absl::string_view name) ABSL_LOCKS_EXCLUDED(mutex_);
  // Does the same, and makes the mission where there is none. `make` is called with the lock held;
  // what it makes goes with its last user, unless something was written of it (Mission::IsVacant).
  absl::StatusOr<Lease> UseOrMake(absl::string_view name, Make make) ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns the mission if it is in memory, else null; nobody waits.
  Lease UseIfLoaded(absl::string_view name) ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns the mission if it is in memory, else an error: NOT_FOUND, DATA_LOSS, or UNAVAILABLE for
  // one that is asleep, wakes or falls asleep.
  absl::StatusOr<Lease> UseLoaded(absl::string_view name) ABSL_LOCKS_EXCLUDED(mutex_);

  // These calls only look: what they return may leave memory, and their callers are no users.

  // Returns NOT_FOUND where there is none, or one that is being made.
  absl::StatusOr<KnownMission> Peek(absl::string_view name) const ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns those behind `after` in the order of names, `count` at most.
  std::vector<KnownMission> List(absl::string_view after, size_t count) const
      ABSL_LOCKS_EXCLUDED(mutex_);
  std::vector<std::weak_ptr<Mission>> ListLoaded() const ABSL_LOCKS_EXCLUDED(mutex_);
  Counts Count() const ABSL_LOCKS_EXCLUDED(mutex_);

  // Missions that come and go.

  void Add(const std::string& name, std::shared_ptr<Mission> mission) ABSL_LOCKS_EXCLUDED(mutex_);
  // Does nothing where there is a mission of the name already.
  void AddEvicted(const std::string& name, EvictedMission evicted) ABSL_LOCKS_EXCLUDED(mutex_);
  // Removes the mission if it is this one, whoever uses it; null: if it can't be read.
  void Remove(const std::string& name, const Mission* mission) ABSL_LOCKS_EXCLUDED(mutex_);
  void AddUnreadable(const std::string& name, absl::Status damage) ABSL_LOCKS_EXCLUDED(mutex_);
  // Keeps the name for a mission that is being made. ALREADY_EXISTS or DATA_LOSS where there is
  // one; `check_room`, called with the lock held, has its say.
  absl::Status Reserve(const std::string& name,
                       absl::FunctionRef<absl::Status(const Counts&)> check_room)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Ends that: null gives the name up.
  void EndMaking(const std::string& name, std::shared_ptr<Mission> mission)
      ABSL_LOCKS_EXCLUDED(mutex_);

  // Tells one life of a name from the next one.
  using Life = std::weak_ptr<const void>;
  absl::StatusOr<Life> FindLife(absl::string_view name) const ABSL_LOCKS_EXCLUDED(mutex_);
  // Waits until the mission neither wakes nor falls asleep, and returns it if it is in memory, null
  // if it is not. From here on it stays as it is until EndDeletion, which removes it if it is
  // deleted. NOT_FOUND if it is not that life any more. With `closed_because` new users are kept
  // out (UNAVAILABLE); those who have a lease may not have said so yet: they ask CheckEntered then.
  absl::StatusOr<std::shared_ptr<Mission>> BeginDeletion(absl::string_view name, const Life& life,
                                                         std::string closed_because = "")
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns UNAVAILABLE if the mission has gone since it was leased, or nobody may come any more.
  absl::Status CheckEntered(absl::string_view name, const Mission& mission) const
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Does as BeginDeletion does for a mission that nobody uses, if `is_due`, called with the lock
  // held, says so: from here on nobody can use it (UNAVAILABLE). Returns none if it stays.
  std::optional<KnownMission> BeginExpiry(absl::string_view name,
                                          absl::FunctionRef<bool(const KnownMission&)> is_due)
      ABSL_LOCKS_EXCLUDED(mutex_);
  void EndDeletion(absl::string_view name, bool deleted) ABSL_LOCKS_EXCLUDED(mutex_);

  // Falling asleep.

  struct Unused {
    std::string name;
    std::shared_ptr<Mission> mission;
    absl::Time last_used;
  };
  // Returns the missions in memory that have no user, the longest unused first.
  std::vector<Unused> ListUnused() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns whether it was not used since.
  bool IsUnused(const Unused& unused) const ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns false if the mission has a user again. Else whoever wants it waits from here on, until
  // one of the two calls below.
  bool BeginEviction(const Unused& unused) ABSL_LOCKS_EXCLUDED(mutex_);
  void CancelEviction(const Unused& unused) ABSL_LOCKS_EXCLUDED(mutex_);
  void EndEviction(const Unused& unused, EvictedMission evicted) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  enum class Stage { kLoaded, kBeingEvicted, kEvicted, kLoading, kUnreadable, kBeingMade };
  struct Entry {
    Stage stage = Stage::kLoaded;
    std::shared_ptr<Mission> mission;               // kLoaded, kBeingEvicted.
    std::shared_ptr<const EvictedMission> evicted;  // kEvicted, kLoading.
    absl::Status damage;                            // kUnreadable.
    size_t users = 0;
    absl::Time last_used;
    // It was made for a robot that has not written anything yet, as far as anybody knew.
    bool may_be_vacant = false;
    bool being_deleted = false;
    std::string closed_because;  // Not empty: nobody may come any more.
    bool gone = false;           // It is not in the map any more.
    // What became of the last attempt to wake it, for those who waited for that.
    absl::Status wake_error;
  };
  using EntryPtr = std::shared_ptr<Entry>;

  absl::StatusOr<EntryPtr> Find(absl::string_view name) const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  EntryPtr& Insert(const std::string& name) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Erase(const EntryPtr& entry) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  static KnownMission Describe(const std::string& name, const Entry& entry);
  Counts CountLocked() const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  // Waits while the mission is on its way. OK: it is awake, or asleep and this caller is to wake it
  // (its stage is kLoading then).
  absl::Status Await(absl::string_view name, Entry& entry) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Returns an error for a mission that nobody can use, whatever they wait for.
  static absl::Status CheckUsable(absl::string_view name, const Entry& entry);
  // Reads the mission, whose stage is kLoading.
  absl::StatusOr<Lease> Wake(const std::string& name, const EntryPtr& entry)
      ABSL_LOCKS_EXCLUDED(mutex_);
  static bool MayRest(const Entry& entry, const Unused& unused);
  Lease LeaseOf(const EntryPtr& entry) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Release(const EntryPtr& entry) ABSL_LOCKS_EXCLUDED(mutex_);

  const std::function<absl::Time()> clock_;
  const Load load_;
  const Asleep asleep_;
  mutable absl::Mutex mutex_;
  std::map<std::string, EntryPtr, std::less<>> entries_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_PROCESS_MISSION_DIRECTORY_H_
