#include "map_store/archive/batch_bytes.h"

#include <variant>

#include "map_store/archive/feature_archive.h"
#include "map_store/archive/record_archive.h"

namespace corbslam::map_store {

std::shared_ptr<const BatchBytes> EncodeBatch(const BatchRecord& record) {
  auto bytes = std::make_shared<BatchBytes>();
  bytes->record = EncodeRecord(record);
  for (const FullKeyframe& keyframe : record.batch->full_keyframes) {
    bytes->features.emplace_back(keyframe.payload->id, EncodeFeatures(*keyframe.payload));
  }
  return bytes;
}

std::shared_ptr<const BatchBytes> BytesOf(const JournalRecord& record) {
  if (const auto* batch = std::get_if<BatchRecord>(&record)) {
    return batch->bytes != nullptr ? batch->bytes : EncodeBatch(*batch);
  }
  return std::make_shared<const BatchBytes>(BatchBytes{EncodeRecord(record), {}});
}

uint64_t SizeOf(const BatchBytes& bytes) {
  uint64_t size = bytes.record.size();
  for (const auto& [id, features] : bytes.features) size += features.size();
  return size;
}

}  // namespace corbslam::map_store
