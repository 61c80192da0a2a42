// Files of a spool in tests of power cuts: a ledger beside them knows what of each was synced, and
// outlives the process that is killed.
#ifndef CORBSLAM_CLIENT_AGENT_SPOOL_TESTING_UNSYNCED_LOSS_FILES_H_
#define CORBSLAM_CLIENT_AGENT_SPOOL_TESTING_UNSYNCED_LOSS_FILES_H_

#include <cstdint>
#include <memory>
#include <random>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client_agent/spool/spool_files.h"

namespace corbslam::client_agent {

// Opens the folder as OpenSpoolFolder does. `ledger` is a file that is not in it; files that are
// removed are kept in the folder LEDGER.removed, as a removal may not have reached the disk either.
absl::StatusOr<std::unique_ptr<SpoolFiles>> OpenUnsyncedLossFolder(const std::string& folder,
                                                                   const std::string& ledger);

// What a power cut did to a spool's folder.
struct PowerCutLoss {
  uint64_t lost_bytes = 0;  // Of what had not been synced.
  int came_back = 0;        // Removed files that are there again.
};

// Leaves of the folder what a disk might hold had the power gone when its process was killed: of
// each file what was synced, and any part of the rest, zeros for some of it; of those that were
// removed some are there again.
PowerCutLoss CutPower(const std::string& folder, const std::string& ledger, std::mt19937& random);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SPOOL_TESTING_UNSYNCED_LOSS_FILES_H_
