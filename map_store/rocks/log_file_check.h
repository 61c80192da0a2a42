// Compares RocksDB's logs with their checksums: the write-ahead log and the list of files
// (MANIFEST) have the same form. RocksDB itself does so only when it opens them.
#ifndef CORBSLAM_MAP_STORE_ROCKS_LOG_FILE_CHECK_H_
#define CORBSLAM_MAP_STORE_ROCKS_LOG_FILE_CHECK_H_

#include <cstdint>
#include <functional>
#include <limits>
#include <string>

#include "absl/status/statusor.h"

namespace corbslam::map_store {

struct LogFileCheck {
  uint64_t bytes = 0;         // That were looked at.
  uint64_t intact_bytes = 0;  // Of intact records, from the beginning on.
  // Why the next record is none; empty: nothing follows the intact ones.
  std::string problem;
  // The rest may be what a power cut or a kill leaves of a record that nobody was told of; else
  // something was there that has changed.
  bool may_be_torn = false;
  // Of a write-ahead log: the sequence number of the last write in intact records; 0: none.
  uint64_t last_sequence = 0;
};

// Is told how many bytes were read, now and then, and says whether to go on.
using ReadPace = std::function<bool(uint64_t bytes)>;

// Reads the file up to `end`. NOT_FOUND: there is none; DATA_LOSS: it can't be read; CANCELLED by
// `goes_on`. The error names the file.
absl::StatusOr<LogFileCheck> CheckLogFile(
    const std::string& path, uint64_t end = std::numeric_limits<uint64_t>::max(),
    const ReadPace& goes_on = [](uint64_t) { return true; });

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_LOG_FILE_CHECK_H_
