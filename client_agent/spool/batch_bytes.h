// Estimates what a batch takes.
#ifndef CORBSLAM_CLIENT_AGENT_SPOOL_BATCH_BYTES_H_
#define CORBSLAM_CLIENT_AGENT_SPOOL_BATCH_BYTES_H_

#include <cstddef>

#include "slam/exchange/map_update.h"

namespace corbslam::client_agent {

// Returns about how many bytes a batch takes, in memory and on the wire.
size_t ApproximateBytes(const MapUpdateBatch& batch);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SPOOL_BATCH_BYTES_H_
