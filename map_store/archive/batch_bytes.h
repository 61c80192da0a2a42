// Makes of a record what journals write of it.
#ifndef CORBSLAM_MAP_STORE_ARCHIVE_BATCH_BYTES_H_
#define CORBSLAM_MAP_STORE_ARCHIVE_BATCH_BYTES_H_

#include <cstdint>
#include <memory>

#include "map_store/records/journal_records.h"

namespace corbslam::map_store {

std::shared_ptr<const BatchBytes> EncodeBatch(const BatchRecord& record);
// Returns what was prepared of the record (Journal::Prepare), else encodes it; only batches have
// features.
std::shared_ptr<const BatchBytes> BytesOf(const JournalRecord& record);
uint64_t SizeOf(const BatchBytes& bytes);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ARCHIVE_BATCH_BYTES_H_
