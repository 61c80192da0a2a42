// Notes beside a mission's database how far it was durable. RocksDB takes a log that ends early, or
// a list of files that does, for one that was always so short.
#ifndef CORBSLAM_MAP_STORE_ROCKS_DURABLE_MARK_H_
#define CORBSLAM_MAP_STORE_ROCKS_DURABLE_MARK_H_

#include <cstdint>
#include <string>

namespace corbslam::map_store {

inline constexpr char kDurableMark[] = "DURABLE";

// Writes the position of a record that is durable. It is not synced itself: after a power cut the
// mark may be an older one. A failure is none: the mark stays what it was.
void WriteDurableMark(const std::string& folder, uint64_t position);

// Returns the position; 0 where there is no mark, or none that can be read.
uint64_t ReadDurableMark(const std::string& folder);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_DURABLE_MARK_H_
