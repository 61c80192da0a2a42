// Converts map update batches to and from the wire.
#ifndef CORBSLAM_SERVICES_CONVERT_MAP_UPDATE_H_
#define CORBSLAM_SERVICES_CONVERT_MAP_UPDATE_H_

#include <cstddef>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "corbslam/v1/map_update.pb.h"
#include "services/convert/features.h"
#include "slam/exchange/map_update.h"

namespace corbslam::services {

// Returns one or more messages of about `part_bytes` at most (a single keyframe is never split).
// `sent` has the cameras named on this stream and learns those of the batch.
std::vector<v1::MapUpdateBatch> ToProto(const MapUpdateBatch& batch, CameraBook& sent,
                                        size_t part_bytes, FeatureForm form = FeatureForm::kPlain);

// Reads one message; `continues` is the assembler's part. `cameras` has those named on this stream
// and learns more. INVALID_ARGUMENT names the item and the limit; PERMISSION_DENIED: the batch has
// somebody else's item where only the sender's are allowed.
absl::StatusOr<MapUpdateBatch> FromProto(const v1::MapUpdateBatch& proto, CameraBook& cameras);

// Returns about what the message takes without coded features, and at least what it takes as it is.
size_t UncodedBytes(const v1::MapUpdateBatch& proto);

// Puts the parts of a batch together. Not thread-safe.
class BatchAssembler {
 public:
  // Returns the batch once its last part is there. INVALID_ARGUMENT: a part of another batch came
  // in between; RESOURCE_EXHAUSTED: there are more than kMaxUpdateBytes, uncoded, or
  // kMaxUpdateItems.
  absl::StatusOr<std::optional<MapUpdateBatch>> Add(const v1::MapUpdateBatch& part,
                                                    CameraBook& cameras);

 private:
  std::optional<MapUpdateBatch> started_;
  size_t bytes_ = 0;
  size_t items_ = 0;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_MAP_UPDATE_H_
