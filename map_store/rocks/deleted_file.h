// Remembers in a journal's folder which missions were deleted: a line of each, its name and uid.
#ifndef CORBSLAM_MAP_STORE_ROCKS_DELETED_FILE_H_
#define CORBSLAM_MAP_STORE_ROCKS_DELETED_FILE_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "map_store/records/journal.h"

namespace corbslam::map_store {

inline constexpr char kDeletedFile[] = "DELETED";

// Adds a line to the folder's file, which lasts when the function returns. Errors name the file.
absl::Status AddToDeletedFile(const std::string& folder, const DeletedMission& mission);
// Returns the last Journal::kMaxDeleted missions of the file, the oldest first; none where there is
// no file. A line that is none is passed over: the last one may have been cut short.
std::vector<DeletedMission> ReadDeletedFile(const std::string& folder);
// Writes a file anew that has grown to twice that; nothing depends on it.
void ShortenDeletedFile(const std::string& folder);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_DELETED_FILE_H_
