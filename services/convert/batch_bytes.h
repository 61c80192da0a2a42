// Turns map update batches to bytes that stand for themselves, as for files, where there is no
// earlier message of a stream to look cameras up in.
#ifndef CORBSLAM_SERVICES_CONVERT_BATCH_BYTES_H_
#define CORBSLAM_SERVICES_CONVERT_BATCH_BYTES_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "slam/exchange/map_update.h"

namespace corbslam::services {

// Returns one serialised v1::MapUpdateBatch, rounded as on the wire; features are rounded once
// only, however often they pass.
std::string EncodeBatch(const MapUpdateBatch& batch);

// Returns INVALID_ARGUMENT where the bytes are no batch, or one that the wire's rules forbid.
absl::StatusOr<MapUpdateBatch> DecodeBatch(absl::string_view bytes);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_BATCH_BYTES_H_
