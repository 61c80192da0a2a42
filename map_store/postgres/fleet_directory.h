// Reads the directory of stores and missions in a database, and writes down what its operator wants
// of them. Stores find that when they prolong their leases.
#ifndef CORBSLAM_MAP_STORE_POSTGRES_FLEET_DIRECTORY_H_
#define CORBSLAM_MAP_STORE_POSTGRES_FLEET_DIRECTORY_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "map_store/fleet/directory.h"
#include "map_store/fleet/fleet_counts.h"
#include "map_store/postgres/postgres_options.h"
#include "map_store/postgres/sql_values.h"

namespace corbslam::map_store {
class SqlPool;

// Errors name the database. Thread-safe.
class FleetDirectory {
 public:
  // `pool` must outlive it; `own` is the number of the process whose missions and store are its own
  // (MissionHolder::id), 0: none's.
  explicit FleetDirectory(SqlPool* pool, int64_t own = 0) : pool_(*pool), own_(own) {}

  // Returns all stores that are remembered, by name.
  absl::StatusOr<std::vector<DirectoryStore>> ListStores() const;
  // Returns missions behind `after` in the order of names, `count` at most.
  absl::StatusOr<std::vector<DirectoryMission>> List(absl::string_view after, size_t count) const;
  // Returns a mission, and the number of its row. NOT_FOUND.
  absl::StatusOr<DirectoryMission> Look(absl::string_view mission, int64_t* row_id = nullptr) const;

  using Duty = StoreDuty;
  // Wants this of the store, which is called by its name or its address. Returns its name.
  // NOT_FOUND: the directory has none; FAILED_PRECONDITION: it has several of that address.
  absl::StatusOr<std::string> SetDuty(const std::string& store, Duty duty);
  // Wants the mission to be at the store. Errors likewise; FAILED_PRECONDITION also if that is not
  // alive, or takes no missions.
  absl::Status Move(const std::string& mission, const std::string& store);

  // Begins a move from one store to another that balances loads, by their names, and returns
  // whether that is so: neither has taken part in one for `rest`. What two stores begin at the same
  // moment, one of them has.
  absl::StatusOr<bool> BeginBalancing(const std::string& giver, const std::string& taker,
                                      absl::Duration rest) const;
  // Returns the standbys that commits wait for; UNIMPLEMENTED: the database does not say.
  absl::StatusOr<StandbyCounts> CountStandbys() const;

 private:
  absl::StatusOr<DirectoryStore> FindStore(const std::string& store) const;

  SqlPool& pool_;
  const int64_t own_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_POSTGRES_FLEET_DIRECTORY_H_
