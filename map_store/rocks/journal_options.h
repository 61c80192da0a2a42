// The options of a journal on RocksDB.
#ifndef CORBSLAM_MAP_STORE_ROCKS_JOURNAL_OPTIONS_H_
#define CORBSLAM_MAP_STORE_ROCKS_JOURNAL_OPTIONS_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"

namespace rocksdb {
class Env;
}  // namespace rocksdb

namespace corbslam::map_store {

struct RocksJournalOptions {
  std::string directory;
  // A mission gets a snapshot when its records since the last one are larger than this and than
  // that snapshot.
  uint64_t min_bytes_between_snapshots = 32 << 20;
  // So many bytes of the disk are left free: with less, records and snapshots are refused. The
  // databases need them to tidy up.
  uint64_t min_free_bytes = 64 << 20;
  // True: the folder must be there, in this program's format, and nothing of its missions is
  // changed, nor can be. Their logs are read, and stay as they are.
  bool only_read = false;
  // So many bytes of all missions' files a second are read again and compared with their checksums,
  // over and over; 0: none.
  uint64_t scrub_bytes_per_s = 0;
  // False: Sync returns at once, for measurements, and to show that tests of durability would fail.
  bool sync = true;
  // Not owned; null: the system's. Tests put a faulty one here.
  rocksdb::Env* env = nullptr;
};

// Returns RESOURCE_EXHAUSTED, with the numbers, when less than min_free_bytes of the folder's disk
// would be left behind `bytes` more.
absl::Status CheckRoom(const RocksJournalOptions& options, uint64_t bytes);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_JOURNAL_OPTIONS_H_
