// Several stores may keep their missions in one journal. A directory in it says which of them has
// a mission, and for how long.
#ifndef CORBSLAM_MAP_STORE_RECORDS_MISSION_LEASES_H_
#define CORBSLAM_MAP_STORE_RECORDS_MISSION_LEASES_H_

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "map_store/fleet/directory.h"
#include "map_store/fleet/fleet_counts.h"
#include "map_store/fleet/load_meter.h"

namespace corbslam::map_store {

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
  // Returns the store that is to take a mission, which nobody has, instead of this one: it was
  // moved there, or this one takes no more. NOT_FOUND: this one is to take it.
  virtual absl::StatusOr<DirectoryStore> FindTaker(const DirectoryMission& mission) const = 0;
  // Tells the other stores how much this one has to do. Where it is too much for it, one of its
  // missions is soon among ListMoves (map_store/fleet/balance.h).
  virtual void NoteLoad(const WeighedStore& load) = 0;
  virtual FleetCounts counts() const = 0;
  // Returns UNAVAILABLE while this process has not reached the journal for longer than a lease:
  // another one may have its missions.
  virtual absl::Status CheckReached() const = 0;
  // Returns for how long a lease is.
  virtual absl::Duration lease() const = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RECORDS_MISSION_LEASES_H_
