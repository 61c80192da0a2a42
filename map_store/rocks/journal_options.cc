#include "map_store/rocks/journal_options.h"

#include <filesystem>
#include <system_error>

#include "absl/strings/str_cat.h"

namespace corbslam::map_store {

absl::Status CheckRoom(const RocksJournalOptions& options, uint64_t bytes) {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(options.directory, error);
  // Where the system doesn't tell how much room there is, the write will.
  if (error || space.available >= options.min_free_bytes + bytes) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("journal ", options.directory, ": the disk has ", space.available,
                   " bytes free; ", options.min_free_bytes, " are kept, ", bytes, " to write"));
}

}  // namespace corbslam::map_store
