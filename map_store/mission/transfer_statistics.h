// Counts what batches took on their way: items, bytes, time.
#ifndef CORBSLAM_MAP_STORE_MISSION_TRANSFER_STATISTICS_H_
#define CORBSLAM_MAP_STORE_MISSION_TRANSFER_STATISTICS_H_

#include "map_store/state/lookups.h"
#include "slam/exchange/map_update.h"

namespace corbslam::map_store {

// Returns about what the items take on the wire, where the transport does not say it.
BatchTransfer EstimateTransfer(const MapUpdateBatch& batch);

// Adds a batch, whose time is shared out by bytes.
void CountTransfer(const MapUpdateBatch& batch, const BatchTransfer& transfer, double ms,
                   MissionStatistics& statistics);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_TRANSFER_STATISTICS_H_
