#include "map_store/view/map_replay.h"

#include <algorithm>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

constexpr size_t kLeastMoments = 2;
constexpr size_t kMostMoments = 1000;
// A piece is about as long as one of WatchMap's.
constexpr size_t kItemsInAPiece = 5000;

uint64_t CountBytes(const MapChanges& piece) {
  uint64_t bytes = sizeof(piece) + piece.removed_islands.size() * sizeof(IslandId);
  for (const MapChanges::Island& island : piece.islands) {
    bytes += sizeof(island);
    bytes += (island.local_maps.size() + island.parts.size()) *
             (sizeof(LocalMapId) + sizeof(std::string));
    bytes += island.keyframes.size() * sizeof(IslandView::KeyframePlace);
    bytes += island.removed_keyframes.size() * sizeof(KeyframeId);
    bytes += island.points.size() * sizeof(island.points[0]);
    bytes += island.removed_points.size() * sizeof(MapPointId);
  }
  return bytes;
}

}  // namespace

absl::Status ReplayOptions::Validate() const {
  if (max_moments >= kLeastMoments && max_moments <= kMostMoments) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("max_moments is ", max_moments, ", must be ",
                                                 kLeastMoments, " to ", kMostMoments));
}

ReplayProgress ProgressOf(const MissionState& state) {
  ReplayProgress progress{.revision = state.global.revision, .batches = 0};
  // Those of parts and of deleted local maps still count: the number never falls.
  for (const auto& [id, local_map] : state.local_maps) {
    progress.batches += local_map.last_batch;
    for (const JoinedLocalMap& part : local_map.joined) progress.batches += part.last_batch;
  }
  for (const auto& [id, last_batch] : state.forgotten) progress.batches += last_batch;
  return progress;
}

MapReplay::MapReplay(const ReplayOptions& options, const ReplayProgress& last, MemoryCheck memory)
    : options_(options),
      last_(last),
      memory_(std::move(memory)),
      watcher_(0, options.include_points) {}

MapReplay::Plan MapReplay::MakePlan(const ReplayProgress& first) const {
  const uint64_t changes = last_.revision - std::min(first.revision, last_.revision);
  const uint64_t batches = last_.batches - std::min(first.batches, last_.batches);
  const uint64_t most = options_.max_moments;
  const uint64_t room = std::max(most / 2, most - std::min(batches, most));
  const size_t of_revisions = changes < room ? changes + 1 : room;
  // The first state is the first of both, and the end the last of one: neither counts twice. Where
  // no revision but the first is chosen, the end may lie behind the last batch.
  const size_t of_batches = most + 1 - of_revisions - (of_revisions == 1 && changes > 0 ? 1 : 0);
  return {EvenSteps(first.revision, last_.revision, of_revisions),
          EvenSteps(first.batches, last_.batches, of_batches)};
}

absl::Status MapReplay::Note(const MissionState& state) {
  const ReplayProgress now = ProgressOf(state);
  const bool is_first = !plan_.has_value();
  if (is_first) plan_.emplace(MakePlan(now));
  const bool is_revision = plan_->revisions.Reach(now.revision);
  const bool is_batch = plan_->batches.Reach(now.batches);
  // The end is told as such, and not twice.
  const bool is_end = now.revision >= last_.revision && now.batches >= last_.batches;
  if ((!is_revision && !is_batch) || (is_end && !is_first)) return status_;
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
        " of ", last_.revision, ": ask for fewer moments (max_moments is ", options_.max_moments,
        ")", options_.include_points ? ", or without points" : ""));
  }
  RETURN_IF_ERROR(memory_(bytes));
  pieces_.push_back(std::move(piece));
  return absl::OkStatus();
}

}  // namespace corbslam::map_store
