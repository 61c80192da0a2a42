// Keeps a journal as an older program left it, before this one writes its own format into it.
#ifndef CORBSLAM_MAP_STORE_ROCKS_UPGRADE_COPY_H_
#define CORBSLAM_MAP_STORE_ROCKS_UPGRADE_COPY_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"

namespace corbslam::map_store {

// Returns where the copy of a journal's folder of that format is kept: in it, as before-15.
std::string UpgradeCopyPath(const std::string& directory, uint32_t format);

// Makes that copy, durably, of all that is in the journal's folder, so that the older program can
// be started on it. Tables, which never change, are the same files where the disk allows that. A
// copy that is there stays as it is; one that was cut short is made anew. Nobody may write to the
// journal meanwhile. RESOURCE_EXHAUSTED, with how much room it takes, where the disk has not that
// much; UNAVAILABLE for other failures. Errors name the folder, and leave no copy.
absl::Status KeepBeforeUpgrade(const std::string& directory, uint32_t format);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_UPGRADE_COPY_H_
