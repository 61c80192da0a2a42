// Finds in a spool what an earlier process left there of its last local map.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_SPOOLED_MAP_READING_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_SPOOLED_MAP_READING_H_

#include <functional>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/spool/spool.h"
#include "client_agent/upload/spooled_map.h"

namespace corbslam::client_agent {

using ReadSpooled = std::function<absl::StatusOr<MapUpdateBatch>(const SpooledBatch&)>;

// Makes the local map of records that are in order: all that the spool has of it. Errors name the
// batch that is missing (FAILED_PRECONDITION), that the disk has not kept (DATA_LOSS), or that does
// not fit (INVALID_ARGUMENT, with what is wrong).
absl::StatusOr<SpooledMap> ReadSpooledMap(LocalMapId local_map,
                                          const std::vector<SpooledBatch>& records,
                                          const ReadSpooled& read);

// The same for the newest local map that the spool found and that is not closed. NOT_FOUND: there
// is none. To be called after TellHeldBack.
absl::StatusOr<SpooledMap> ReadNewestSpooledMap(Spool& spool);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_SPOOLED_MAP_READING_H_
