// Several stores may keep their missions in one journal. A directory in it says which of them has
// a mission, and for how long.
#ifndef CORBSLAM_MAP_STORE_RECORDS_MISSION_LEASES_H_
#define CORBSLAM_MAP_STORE_RECORDS_MISSION_LEASES_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"

namespace corbslam::map_store {

// A store as the directory has it.
struct DirectoryStore {
  std::string name;     // The same one again after a restart.
  std::string address;  // HOST:PORT, as others reach it.
  std::string machine;
  std::string version;  // Of its program.
  // Until it counts as gone, unless it says again that it lives; by the journal's clock.
  absl::Duration lease_left = absl::ZeroDuration();
  // It takes no more missions, and, drained, gives away those that it has.
  bool is_cordoned = false;
  bool is_drained = false;
  bool is_own = false;    // This process's.
  uint64_t missions = 0;  // That it has.

  bool IsAlive() const { return lease_left > absl::ZeroDuration(); }
};

// A mission as the directory has it.
struct DirectoryMission {
  std::string name;
  bool is_asleep = false;
  // Who has it, of which nobody takes it while `lease_left` is above 0. Asleep missions have none.
  std::string holder;
  std::string address;  // The holder's; empty: not known.
  bool is_own = false;  // This process's.
  int64_t epoch = 0;    // How often it was taken.
  absl::Duration lease_left = absl::ZeroDuration();
  // The store that is to have it, by its name, and its address while it is alive and takes any.
  std::string wanted = {};
  std::string wanted_address = {};
  uint64_t bytes = 0;
  std::string summary = {};  // Of one that is asleep (Journal::PutAside); empty: none is kept.

  bool IsHeldByAnother() const { return !is_own && lease_left > absl::ZeroDuration(); }
};

// Takes, keeps and gives back missions of a journal for this process. A mission is taken by
// Journal::Recover, or with its first record; Journal::PutAside gives it back. Errors of a mission
// that another process has say where (FindElsewhere). Thread-safe.
class MissionLeases {
 public:
  virtual ~MissionLeases() = default;

  // Says that this process is the store of that name and address from now on. What a process
  // before it held under the same name is free for all, and that one takes nothing any more.
  virtual absl::Status Announce(const DirectoryStore& self) = 0;
  // Returns all stores that the directory remembers, by name.
  virtual absl::StatusOr<std::vector<DirectoryStore>> ListStores() const = 0;

  // Returns what the directory says of the mission now. NOT_FOUND: there is none.
  virtual absl::StatusOr<DirectoryMission> Look(absl::string_view mission) const = 0;
  // Returns missions behind `after` in the order of names, `count` at most.
  virtual absl::StatusOr<std::vector<DirectoryMission>> List(absl::string_view after,
                                                             size_t count) const = 0;

  // Gives the mission back, if this process has it, and forgets it.
  virtual void LetGo(absl::string_view mission) = 0;
  // Returns the missions that this process had and has no more, with what their robots are told;
  // each once. LetGo forgets one.
  virtual std::map<std::string, absl::Status> TakeLost() = 0;
  // Returns the missions of this process that another store is to have, with that store.
  virtual std::map<std::string, DirectoryStore> ListMoves() const = 0;
  // Gives the mission back for that store, and forgets it.
  virtual absl::Status GiveTo(absl::string_view mission, const std::string& store) = 0;
  // Returns who takes missions in the place of this store, which is cordoned; NOT_FOUND: it is not,
  // or there is nobody.
  virtual absl::StatusOr<DirectoryStore> FindSubstitute() const = 0;
  // Returns UNAVAILABLE while this process has not reached the journal for longer than a lease:
  // another one may have its missions.
  virtual absl::Status CheckReached() const = 0;
  // Returns for how long a lease is.
  virtual absl::Duration lease() const = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RECORDS_MISSION_LEASES_H_
