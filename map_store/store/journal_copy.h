// Copies missions from one journal to another, and compares what came of it.
#ifndef CORBSLAM_MAP_STORE_STORE_JOURNAL_COPY_H_
#define CORBSLAM_MAP_STORE_STORE_JOURNAL_COPY_H_

#include <cstddef>
#include <functional>
#include <string>

#include "absl/status/status.h"
#include "map_store/records/journal.h"

namespace corbslam::map_store {

struct CopiedMission {
  std::string name;
  // OK: the copy is what the mission is, item by item. ALREADY_EXISTS: there is another mission of
  // the name, which was left as it is. DATA_LOSS: the mission is damaged, or the copy is not like
  // it; nothing of it was left.
  absl::Status status;
  bool was_there = false;  // An earlier copy, which is like it.
  size_t agents = 0;
  size_t local_maps = 0;
  size_t keyframes = 0;
  size_t pictures = 0;
};

// Copies all missions of `from` into `to`, with their pictures and what `from` remembers of
// missions that were; `tell` is told of each. What is copied is a mission as it is now: its past,
// which a viewer plays, is not. Nobody else may use either journal meanwhile. Run again, it goes on
// with those that are missing. An error is one of the journal as a whole.
absl::Status CopyJournal(Journal& from, Journal& to,
                         const std::function<void(const CopiedMission& mission)>& tell);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STORE_JOURNAL_COPY_H_
