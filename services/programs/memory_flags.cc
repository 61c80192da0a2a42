#include "services/programs/memory_flags.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "services/command_line/help_formatter.h"
#include "services/command_line/values.h"

namespace corbslam::services {
namespace {

// More has no computer.
constexpr uint64_t kMost_bytes = uint64_t{1} << 50;

std::string MiB(uint64_t bytes) { return absl::StrCat(bytes >> 20, " MiB"); }

}  // namespace

void AddMemoryFlags(CLI::App& app, MemoryFlags& flags) {
  app.add_option("--memory-budget", flags.budget_bytes,
                 "Memory of the process, as 500MB, beyond which far parts of the map leave it for "
                 "the map store (without one for --spool) and come back when they are near; 0: no "
                 "bound")
      ->transform(BytesWithin({.may_be_0 = true}))
      ->type_name(kBytesType)
      ->capture_default_str()
      ->group(kRareGroup);
}

absl::Status CheckMemoryFlags(const MemoryFlags& flags, const ShareFlags& share,
                              uint64_t outbox_bytes, bool has_keeper) {
  if (flags.budget_bytes == 0) return absl::OkStatus();
  if (!has_keeper) {
    return absl::InvalidArgumentError(
        "--memory-budget needs --server or --spool: what leaves memory is kept by a map store or "
        "on the disk, and without either it would be lost");
  }
  const uint64_t least = kRobotItself_bytes + outbox_bytes + kLeastForMap_bytes;
  if (flags.budget_bytes < least) {
    return absl::InvalidArgumentError(
        absl::StrCat("--memory-budget is ", flags.budget_bytes, " bytes (", MiB(flags.budget_bytes),
                     "), must be at least ", MiB(least), ": ", MiB(kRobotItself_bytes),
                     " for the robot without a map, ", MiB(outbox_bytes), " for --outbox-mb, ",
                     MiB(kLeastForMap_bytes), " for a map. Give it with a unit, as 500MB"));
  }
  if (flags.budget_bytes > kMost_bytes) {
    return absl::InvalidArgumentError(absl::StrCat("--memory-budget is ", MiB(flags.budget_bytes),
                                                   ", must be at most ", MiB(kMost_bytes)));
  }
  if (share.mode == ShareMode::kEverything) {
    return absl::InvalidArgumentError(
        "--share everything has no bound in memory, so that --memory-budget can't be kept: use "
        "--share nearby (which is the default with it), corrections or none");
  }
  return absl::OkStatus();
}

uint64_t MaxMapBytes(const MemoryFlags& flags, uint64_t outbox_bytes, bool has_server) {
  if (flags.budget_bytes == 0) return 0;
  return (flags.budget_bytes - kRobotItself_bytes - outbox_bytes) / (has_server ? 2 : 3);
}

}  // namespace corbslam::services
