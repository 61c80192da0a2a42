// Makes a backup of what can be had of a damaged mission in a stopped store's folder.
#ifndef CORBSLAM_MAP_STORE_STORE_JOURNAL_REPAIR_H_
#define CORBSLAM_MAP_STORE_STORE_JOURNAL_REPAIR_H_

#include <cstddef>
#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "map_store/rocks/salvaged_journal.h"

namespace corbslam::map_store {

struct RepairReport {
  // What was read and what was lost. Those of `without_features` that are still in the map were
  // left out of it; the others had been removed by their robots.
  SalvageReport salvage;
  size_t left_out = 0;
  // What the file has.
  size_t agents = 0;
  size_t local_maps = 0;
  size_t keyframes = 0;
  uint64_t bytes = 0;
};

// Writes a file that `mission restore` takes. Nothing in `directory` is changed.
// FAILED_PRECONDITION: a store has the folder open, or its format is unknown; NOT_FOUND: there is
// no such mission; INVALID_ARGUMENT: the file would lie in the folder; ALREADY_EXISTS: there is one
// of that name; DATA_LOSS: nothing can be had.
absl::StatusOr<RepairReport> RepairMission(const std::string& directory, const std::string& mission,
                                           const std::string& file);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STORE_JOURNAL_REPAIR_H_
