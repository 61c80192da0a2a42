// What a robot uploaded in one run, to be streamed again by any number of robots: real batches at
// the price of sending them.
#ifndef CORBSLAM_TESTS_REPLAY_RECORDED_UPLOADS_H_
#define CORBSLAM_TESTS_REPLAY_RECORDED_UPLOADS_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/upload/feature_selection.h"
#include "slam/exchange/map_update.h"
#include "slam/vocabulary/vocabulary.h"

namespace corbslam::tests {

// All batches of one local map, numbered from 1; the last closes it.
using RecordedUploads = std::vector<MapUpdateBatch>;

// Runs an agent on the source (as `client_agent --source`) alone and in lockstep, as fast as it
// goes. The result is the same every time. FAILED_PRECONDITION: it made more than one local map.
absl::StatusOr<RecordedUploads> RecordUploads(const std::string& source,
                                              std::shared_ptr<const Vocabulary> vocabulary,
                                              const client_agent::FeatureSelection& features = {});

// Returns the same batch as another local map's: every id of its own map is renamed.
MapUpdateBatch AsLocalMap(const MapUpdateBatch& batch, LocalMapId local_map);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_REPLAY_RECORDED_UPLOADS_H_
