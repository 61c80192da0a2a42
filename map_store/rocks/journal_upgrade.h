// Moves missions out of the one database that journals had up to format 10.
#ifndef CORBSLAM_MAP_STORE_ROCKS_JOURNAL_UPGRADE_H_
#define CORBSLAM_MAP_STORE_ROCKS_JOURNAL_UPGRADE_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "map_store/rocks/journal_options.h"
#include "map_store/rocks/rocks_database.h"

namespace corbslam::map_store {

// Returns the missions of such a database that are whole: of the others nobody was told.
absl::StatusOr<std::vector<std::string>> ListSharedMissions(const RocksDatabase& shared);

// Copies each mission into a database of its own, all of them or none: the folder of missions is
// there when the function returns OK. What was copied by an attempt that was cut short is not
// copied again, if nothing was written to `shared` since. Nothing of `shared` is changed.
// RESOURCE_EXHAUSTED, with how much room it takes, where the disk has not that much.
absl::Status UpgradeJournal(const RocksJournalOptions& options, const RocksDatabase& shared,
                            const std::shared_ptr<rocksdb::Cache>& cache);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_JOURNAL_UPGRADE_H_
