// Says what an upgrade of a stopped store's folder would do, and does it.
#ifndef CORBSLAM_MAP_STORE_ROCKS_JOURNAL_REHEARSAL_H_
#define CORBSLAM_MAP_STORE_ROCKS_JOURNAL_REHEARSAL_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace corbslam::map_store {

struct MissionToUpgrade {
  std::string name;
  uint64_t records = 0;    // Since its snapshot.
  uint64_t keyframes = 0;  // Of which there are features.
  uint64_t bytes = 0;      // Of keys and values.
};

struct UpgradePlan {
  uint32_t from = 0;  // The folder's format; 0: there is no journal yet.
  uint32_t to = 0;    // That of this program.
  // Those of formats that have to be upgraded.
  std::vector<MissionToUpgrade> missions;
  // Of the disk, for a while; 0: missions become the new ones where they are.
  uint64_t bytes_needed = 0;
  uint64_t bytes_free = 0;
  bool needed() const { return from != 0 && from < to; }
};

// Reads all that would be copied, and changes nothing. FAILED_PRECONDITION: a store has the folder
// open, or it is of a format that this program does not read, with both and the version that wrote
// it, if that is known; DATA_LOSS names what can't be read, and would stop the upgrade.
absl::StatusOr<UpgradePlan> PlanUpgrade(const std::string& directory);

// Does it. After an error, or a kill, it is called again, and goes on with the mission at which it
// ended; until it is done an older program finds the folder as it was.
absl::Status UpgradeFolder(const std::string& directory);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_JOURNAL_REHEARSAL_H_
