#include "map_store/view/map_replay.h"

#include <algorithm>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

constexpr size_t kLeastRevisions = 2;
constexpr size_t kMostRevisions = 1000;
// A piece is about as long as one of WatchMap's.
constexpr size_t kItemsInAPiece = 5000;

uint64_t CountBytes(const MapChanges& piece) {
  uint64_t bytes = sizeof(piece) + piece.removed_islands.size() * sizeof(IslandId);
  for (const MapChanges::Island& island : piece.islands) {
    bytes += sizeof(island);
    bytes += island.local_maps.size() * (sizeof(LocalMapId) + sizeof(std::string));
    bytes += island.keyframes.size() * sizeof(IslandView::KeyframePlace);
    bytes += island.removed_keyframes.size() * sizeof(KeyframeId);
    bytes += island.points.size() * sizeof(island.points[0]);
    bytes += island.removed_points.size() * sizeof(MapPointId);
  }
  return bytes;
}

}  // namespace

absl::Status ReplayOptions::Validate() const {
  if (max_revisions >= kLeastRevisions && max_revisions <= kMostRevisions) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("max_revisions is ", max_revisions, ", must be ",
                                                 kLeastRevisions, " to ", kMostRevisions));
}

MapReplay::MapReplay(const ReplayOptions& options, uint64_t last_revision, MemoryCheck memory)
    : options_(options),
      last_revision_(last_revision),
      memory_(std::move(memory)),
      watcher_(0, options.include_points) {}

uint64_t MapReplay::Chosen(size_t index) const {
  const uint64_t steps = last_revision_ - std::min(*first_revision_, last_revision_);
  const uint64_t most = options_.max_revisions - 1;
  return *first_revision_ + (steps <= most ? index : index * steps / most);
}

bool MapReplay::IsDue(uint64_t revision) const {
  return next_ < options_.max_revisions && Chosen(next_) <= revision;
}

absl::Status MapReplay::Look(const MissionState& state) {
  const uint64_t revision = state.global.revision;
  if (!first_revision_.has_value()) first_revision_ = revision;
  // The last revision is told at the end, with what owners said after it.
  if (!IsDue(revision) || (next_ > 0 && revision >= last_revision_)) return status_;
  while (IsDue(revision)) ++next_;
  return Tell(state);
}

absl::Status MapReplay::End(const MissionState& state) { return Tell(state); }

absl::Status MapReplay::Tell(const MissionState& state) {
  while (status_.ok()) {
    std::optional<MapChanges> piece = watcher_.Next(state, kItemsInAPiece);
    if (!piece.has_value()) break;
    const bool continues = piece->continues;
    status_ = Keep(*std::move(piece));
    if (!continues) break;
  }
  return status_;
}

absl::Status MapReplay::Keep(MapChanges piece) {
  const uint64_t bytes = CountBytes(piece);
  bytes_ += bytes;
  if (bytes_ > options_.max_bytes) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "the replay is longer than ", options_.max_bytes, " bytes at revision ", piece.revision,
        " of ", last_revision_, ": ask for fewer revisions (max_revisions is ",
        options_.max_revisions, ")", options_.include_points ? ", or without points" : ""));
  }
  RETURN_IF_ERROR(memory_(bytes));
  pieces_.push_back(std::move(piece));
  return absl::OkStatus();
}

}  // namespace corbslam::map_store
