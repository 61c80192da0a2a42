// Keeps a few bytes beside a mission's database that is closed: what a store says of the mission
// without opening it.
#ifndef CORBSLAM_MAP_STORE_ROCKS_SUMMARY_FILE_H_
#define CORBSLAM_MAP_STORE_ROCKS_SUMMARY_FILE_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam::map_store {

inline constexpr char kSummaryFile[] = "SUMMARY";

// Writes the file for the database as it is closed now; it lasts when the function returns, as a
// whole or not at all.
absl::Status WriteSummaryFile(const std::string& folder, absl::string_view summary);

// Returns what was written. NOT_FOUND: there is no file. DATA_LOSS: it is damaged, or something has
// opened the database since: each opening gives it a new list of files, by whose name that shows.
absl::StatusOr<std::string> ReadSummaryFile(const std::string& folder);

// Removes the file, if there is one, for a database that is about to be opened.
void RemoveSummaryFile(const std::string& folder);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_SUMMARY_FILE_H_
