// Reads all that is in a journal's folder, to find what is damaged before a store does.
#ifndef CORBSLAM_MAP_STORE_STORE_JOURNAL_CHECK_H_
#define CORBSLAM_MAP_STORE_STORE_JOURNAL_CHECK_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace corbslam::map_store {

struct CheckedMission {
  std::string name;
  absl::Status status;  // DATA_LOSS, with the file or the record; OK: nothing is damaged.
  // Files whose damage loses nothing, each with what becomes of it.
  std::vector<std::string> notes;
  uint64_t disk_bytes = 0;
  // What it holds, if nothing is damaged.
  size_t agents = 0;
  size_t local_maps = 0;
  size_t keyframes = 0;
};

// Calls `tell` for each mission in turn: its files are compared with their checksums, and all its
// records are decoded, checked and applied as a store does at its start. One mission at a time is
// in memory, and none is changed. FAILED_PRECONDITION: no journal is there, a store has it open,
// or it is of another format.
absl::Status CheckJournal(const std::string& directory,
                          const std::function<void(const CheckedMission&)>& tell);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STORE_JOURNAL_CHECK_H_
