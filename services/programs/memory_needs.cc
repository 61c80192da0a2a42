#include "services/programs/memory_needs.h"

#include <algorithm>
#include <string>

#include "absl/strings/str_cat.h"

namespace corbslam::services {
namespace {

// Measured on short drives without a budget (docs/robot.md): programs with the vocabulary that is
// shipped, threads' heaps and connections, ...
constexpr uint64_t kPrograms_bytes = uint64_t{96} << 20;
// ... what a pixel of one picture takes, in pyramids, rectification, pictures read ahead, and those
// of the newest keyframes (KeyframePictures: sixteen, each a third larger than its pixels), ...
constexpr uint64_t kBytesPerPixel = 62;
// ... and a feature, in frames that are under way.
constexpr uint64_t kBytesPerFeature = 2048;
// A keyframe's feature in the map, with the part of a point that it sees.
constexpr uint64_t kMapBytesPerFeature = 200;
constexpr uint64_t kLeastKeyframes = 40;

constexpr uint64_t kMostForOutbox_bytes = uint64_t{64} << 20;
constexpr uint64_t kOutboxShare = 8;

std::string MiB(uint64_t bytes) { return absl::StrCat(bytes >> 20, " MiB"); }

}  // namespace

uint64_t RobotItselfBytes(const MemoryNeeds& needs) {
  const uint64_t pixels =
      static_cast<uint64_t>(needs.width_px) * static_cast<uint64_t>(needs.height_px);
  return kPrograms_bytes + kBytesPerPixel * pixels +
         kBytesPerFeature * static_cast<uint64_t>(needs.features);
}

uint64_t LeastBytesForMap(const MemoryNeeds& needs) {
  // One half is the local map's (MaxMapBytes).
  return 2 * kLeastKeyframes * kMapBytesPerFeature * static_cast<uint64_t>(needs.features);
}

uint64_t OutboxBytesOf(uint64_t budget_bytes) {
  if (budget_bytes == 0) return kMostForOutbox_bytes;
  return std::min(kMostForOutbox_bytes, budget_bytes / kOutboxShare);
}

absl::Status CheckMemoryBudget(uint64_t budget_bytes, std::optional<ShareMode> share,
                               const MemoryNeeds& needs, bool has_keeper) {
  if (budget_bytes == 0) return absl::OkStatus();
  if (!has_keeper) {
    return absl::InvalidArgumentError(
        "--memory-budget needs --server or --spool: what leaves memory is kept by a map store or "
        "on the disk, and without either it would be lost");
  }
  const uint64_t itself = RobotItselfBytes(needs);
  const uint64_t map = LeastBytesForMap(needs);
  const uint64_t least = itself + needs.outbox_bytes + map;
  if (budget_bytes < least) {
    const std::string pictures =
        needs.width_px > 0 ? absl::StrCat(" of ", needs.width_px, "x", needs.height_px) : "";
    return absl::InvalidArgumentError(absl::StrCat(
        "--memory-budget is ", budget_bytes, " bytes (", MiB(budget_bytes), "), must be at least ",
        MiB(least + (uint64_t{1} << 20) - 1), " with ", needs.features, " features of pictures",
        pictures, ": ", MiB(itself), " for the robot without a map, ", MiB(needs.outbox_bytes),
        " for --outbox-mb, ", MiB(map),
        " for a map. Give it with a unit, as 500MB; fewer --features and a smaller --outbox-mb "
        "take less"));
  }
  if (share == ShareMode::kEverything) {
    return absl::InvalidArgumentError(
        "--share everything has no bound in memory, so that --memory-budget can't be kept: use "
        "--share nearby (which is the default with it), corrections or none");
  }
  return absl::OkStatus();
}

uint64_t MaxMapBytes(uint64_t budget_bytes, const MemoryNeeds& needs, bool has_server) {
  if (budget_bytes == 0) return 0;
  const uint64_t taken = RobotItselfBytes(needs) + needs.outbox_bytes;
  // An outbox that was made before the budget was set may be larger than the budget would have it.
  const uint64_t left = budget_bytes - std::min(budget_bytes, taken);
  return std::max(left, LeastBytesForMap(needs)) / (has_server ? 2 : 3);
}

}  // namespace corbslam::services
