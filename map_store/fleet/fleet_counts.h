// What happened to a store's leases, for people who look after it.
#ifndef CORBSLAM_MAP_STORE_FLEET_FLEET_COUNTS_H_
#define CORBSLAM_MAP_STORE_FLEET_FLEET_COUNTS_H_

#include <cstdint>
#include <optional>

#include "map_store/fleet/directory.h"

namespace corbslam::map_store {

// The standbys that commits of a database wait for.
struct StandbyCounts {
  uint64_t wanted = 0;  // 0: commits wait for none.
  uint64_t there = 0;
};

struct FleetCounts {
  uint64_t held = 0;   // Missions that the store has.
  uint64_t given = 0;  // Missions that it gave to another store, those to balance included.
  uint64_t given_to_balance = 0;
  uint64_t lost = 0;            // Missions that another store took over.
  uint64_t refused_writes = 0;  // Writes that were refused, since the mission is another one's.
  bool reaches_database = true;
  uint64_t unreached = 0;                      // How often leases could not be prolonged.
  uint64_t busy_pool = 0;                      // How often no connection was free for too long.
  std::optional<StandbyCounts> standbys = {};  // Nullopt: the database does not say.
  std::optional<StoreLoad> load = {};          // As others are told it.
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_FLEET_FLEET_COUNTS_H_
