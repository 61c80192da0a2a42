// Writes files of all missions into a folder, for timers, and removes old ones.
#ifndef CORBSLAM_SERVICES_TOOL_MISSION_FILE_BACKUPS_H_
#define CORBSLAM_SERVICES_TOOL_MISSION_FILE_BACKUPS_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "services/tool/mission/mission_admin.h"

namespace corbslam::services {

struct FileBackupOptions {
  std::string folder;
  size_t keep = 7;  // Files of a mission that stay, the newest ones; at least 1.
};

// Writes DIR/MISSION/YYYYMMDDTHHMMSSZ.backup of each mission of the store, by the time `now`, and
// then removes those of these names beyond the newest `keep`; other files stay. `tell` is called
// with each mission and what came of it. What is wrong with one mission does not stop the others:
// the first error is returned at the end, with how many there were.
absl::Status BackUpAll(MissionAdmin& admin, const FileBackupOptions& options, absl::Time now,
                       const std::function<void(const std::string& mission,
                                                const absl::StatusOr<std::string>& file)>& tell);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_MISSION_FILE_BACKUPS_H_
