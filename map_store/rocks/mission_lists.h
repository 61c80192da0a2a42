// Keeps a journal's lists of missions, a file of its folder each: a line of each mission, its name
// and uid.
#ifndef CORBSLAM_MAP_STORE_ROCKS_MISSION_LISTS_H_
#define CORBSLAM_MAP_STORE_ROCKS_MISSION_LISTS_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "map_store/records/journal.h"

namespace corbslam::map_store {

// Returns "DELETED" or "PROMISED".
std::string FileOfList(MissionList list);

// Adds a line to the list's file, which lasts when the function returns. Errors name the file.
absl::Status AddToMissionList(const std::string& folder, MissionList list,
                              const MissionIdentity& mission);
// Returns the last Journal::kMaxListed missions of the file, the oldest first; none where there is
// no file. A line that is none is passed over: the last one may have been cut short.
std::vector<MissionIdentity> ReadMissionList(const std::string& folder, MissionList list);
// Writes a file anew that has grown to twice that; nothing depends on it.
void ShortenMissionList(const std::string& folder, MissionList list);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_MISSION_LISTS_H_
