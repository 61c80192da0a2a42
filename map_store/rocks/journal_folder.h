// Says where in a journal's folder what lies: a guard, and a folder for each mission.
#ifndef CORBSLAM_MAP_STORE_ROCKS_JOURNAL_FOLDER_H_
#define CORBSLAM_MAP_STORE_ROCKS_JOURNAL_FOLDER_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam::map_store {

// What a mission's folder is for, by the end of its name. Only kept ones are missions: the others
// are what a deletion or a creation has left that was cut short.
inline constexpr char kInUse[] = ".mission";
inline constexpr char kDeleted[] = ".deleted";
inline constexpr char kBeingMade[] = ".making";

// Finds a journal's folders below its `missions`. All errors name the folder.
class JournalFolder {
 public:
  // `directory` is the journal's.
  explicit JournalFolder(const std::string& directory);

  const std::string& path() const { return path_; }
  bool exists() const;
  // Makes the folder, where it is not there yet, so that it outlives a power cut.
  absl::Status Make() const;

  std::string PathOf(absl::string_view mission, absl::string_view use = kInUse) const;
  // Returns the missions that are kept, in the order of their names.
  absl::StatusOr<std::vector<std::string>> ListInUse() const;
  // Changes what the mission's folder is for; that lasts when the function returns.
  absl::Status Turn(absl::string_view mission, absl::string_view from, absl::string_view to) const;
  // Removes a mission's folder of that use, if there is one, with all that is in it.
  absl::Status Remove(absl::string_view mission, absl::string_view use) const;
  // Removes what was cut short.
  absl::Status RemoveLeftovers() const;

 private:
  const std::string path_;
};

// Makes the names in a folder outlive a power cut.
absl::Status SyncFolder(const std::string& path);

// Returns whether `inner` is the folder `outer`, or lies in it, whatever links and dots their names
// have. Neither need be there.
bool IsWithin(const std::string& outer, const std::string& inner);

// Returns how many bytes the folder's files have, those of folders in it included.
uint64_t BytesIn(const std::string& path);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_JOURNAL_FOLDER_H_
