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
#include "map_store/postgres/postgres_options.h"
#include "map_store/postgres/sql_values.h"
#include "map_store/records/mission_leases.h"

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

  enum class Duty : int64_t { kTakesMissions = 0, kCordoned = 1, kDrained = 2 };
  // Wants this of the store, which is called by its name or its address. Returns its name.
  // NOT_FOUND: the directory has none; FAILED_PRECONDITION: it has several of that address.
  absl::StatusOr<std::string> SetDuty(const std::string& store, Duty duty);
  // Wants the mission to be at the store. Errors likewise; FAILED_PRECONDITION also if that is not
  // alive, or takes no missions.
  absl::Status Move(const std::string& mission, const std::string& store);

 private:
  absl::StatusOr<DirectoryStore> FindStore(const std::string& store) const;

  SqlPool& pool_;
  const int64_t own_;
};

// Of the stores that are alive and take missions, this process's aside, returns the one that has
// the fewest; null: there is none.
const DirectoryStore* FindFreest(const std::vector<DirectoryStore>& stores);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_POSTGRES_FLEET_DIRECTORY_H_
