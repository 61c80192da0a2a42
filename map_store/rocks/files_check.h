// Looks at those of a mission's files that its database reads only when it is opened: logs, the
// list of files, and what lies beside the database.
#ifndef CORBSLAM_MAP_STORE_ROCKS_FILES_CHECK_H_
#define CORBSLAM_MAP_STORE_ROCKS_FILES_CHECK_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "map_store/rocks/log_file_check.h"

namespace rocksdb {
class DB;
}  // namespace rocksdb

namespace corbslam::map_store {

struct FilesCheck {
  // Files that the mission needs, each with what is wrong with it.
  std::vector<std::string> damaged;
  // Logs that end within a record, as they do after a kill or a power cut.
  std::vector<std::string> torn;
  // Files whose damage loses nothing, each with what becomes of it.
  std::vector<std::string> notes;

  // DATA_LOSS names all that are damaged.
  absl::Status status() const;
};

// Looks at a folder whose database nobody has open.
FilesCheck CheckClosedFiles(
    const std::string& folder, const ReadPace& goes_on = [](uint64_t) { return true; });

// Returns an error of damage together with the files of the folder that are found damaged or torn
// and that it does not name yet.
absl::Status NameDamagedFiles(const std::string& folder, const absl::Status& error);

// Looks at the files of a database that is open and written to meanwhile. DATA_LOSS names the file;
// CANCELLED by `goes_on`.
absl::Status CheckLiveFiles(rocksdb::DB& db, const ReadPace& goes_on);

// Returns what the folder's CURRENT says; each opening of the database changes it. Empty: it can't
// be read.
std::string ReadCurrentFile(const std::string& folder);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_FILES_CHECK_H_
