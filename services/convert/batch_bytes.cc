#include "services/convert/batch_bytes.h"

#include <limits>
#include <vector>

#include "absl/strings/str_cat.h"
#include "services/convert/limits.h"
#include "services/convert/map_update.h"

namespace corbslam::services {

std::string EncodeBatch(const MapUpdateBatch& batch) {
  CameraBook none_sent;
  // The batch is never split: a file has no limit to its messages.
  const std::vector<v1::MapUpdateBatch> whole =
      ToProto(batch, none_sent, std::numeric_limits<size_t>::max(), FeatureForm::kCoded);
  return whole.front().SerializeAsString();
}

absl::StatusOr<MapUpdateBatch> DecodeBatch(absl::string_view bytes) {
  if (bytes.size() > kMaxUpdateBytes) {
    return absl::InvalidArgumentError(
        absl::StrCat("a batch of ", bytes.size(), " bytes; the limit is ", kMaxUpdateBytes));
  }
  v1::MapUpdateBatch proto;
  if (!proto.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return absl::InvalidArgumentError(
        absl::StrCat(bytes.size(), " bytes that are no MapUpdateBatch"));
  }
  if (const size_t uncoded = UncodedBytes(proto); uncoded > kMaxUpdateBytes) {
    return absl::InvalidArgumentError(
        absl::StrCat("a batch of ", uncoded, " bytes, uncoded; the limit is ", kMaxUpdateBytes));
  }
  CameraBook cameras;
  return FromProto(proto, cameras);
}

}  // namespace corbslam::services
