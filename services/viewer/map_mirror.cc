#include "services/viewer/map_mirror.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

using ProtoIsland = v1::WatchMapResponse::Island;

// Begins an island in a piece, with its local maps.
ProtoIsland* BeginIsland(LocalMapId id, bool in_global_frame,
                         const std::vector<LocalMapId>& local_maps, SlotWriter& slots,
                         v1::WatchMapResponse& piece) {
  ProtoIsland* proto = piece.add_islands();
  proto->set_slot(slots.Slot(id));
  proto->set_in_global_frame(in_global_frame);
  for (const LocalMapId local_map : local_maps) proto->add_local_map_slots(slots.Slot(local_map));
  return proto;
}

}  // namespace

absl::Status MapMirror::Apply(const v1::WatchMapResponse& changes) {
  ASSIGN_OR_RETURN(const SlotReader slots, SlotReader::Create(changes.local_maps()));
  const int named = std::min(changes.local_maps_size(), changes.local_map_agents_size());
  for (int i = 0; i < named; ++i) {
    // What is named in removals alone comes without its agent.
    if (changes.local_map_agents(i).empty()) continue;
    agents_[LocalMapId{changes.local_maps(i)}] = changes.local_map_agents(i);
  }
  for (const uint32_t slot : changes.removed_island_slots()) {
    ASSIGN_OR_RETURN(const LocalMapId island, slots.LocalMap(slot));
    Remove(island);
  }
  for (const ProtoIsland& island : changes.islands()) RETURN_IF_ERROR(ApplyIsland(island, slots));
  version_ = changes.version();
  revision_ = changes.revision();
  return absl::OkStatus();
}

void MapMirror::Remove(LocalMapId island) {
  const auto it = islands_.find(island);
  if (it == islands_.end()) return;
  keyframes_ -= it->second.keyframes.size();
  points_ -= it->second.points.size();
  islands_.erase(it);
}

absl::Status MapMirror::ApplyIsland(const ProtoIsland& changes, const SlotReader& slots) {
  ASSIGN_OR_RETURN(const LocalMapId id, slots.LocalMap(changes.slot()));
  if (changes.anew()) Remove(id);
  Island& island = islands_[id];
  island.in_global_frame = changes.in_global_frame();
  // An island that goes on in a further message does not name its local maps again.
  if (changes.local_map_slots_size() > 0) island.local_maps.clear();
  for (const uint32_t slot : changes.local_map_slots()) {
    ASSIGN_OR_RETURN(island.local_maps.emplace_back(), slots.LocalMap(slot));
  }
  const size_t keyframes_before = island.keyframes.size();
  const size_t points_before = island.points.size();
  absl::Status status = ApplyKeyframes(changes, slots, island);
  if (status.ok()) status = ApplyPoints(changes, slots, island);
  keyframes_ += island.keyframes.size() - keyframes_before;
  points_ += island.points.size() - points_before;
  return status;
}

absl::Status MapMirror::ApplyKeyframes(const ProtoIsland& changes, const SlotReader& slots,
                                       Island& island) {
  for (const Keyframe& proto : changes.keyframes()) {
    ASSIGN_OR_RETURN(const KeyframeId id, slots.Keyframe(proto.id()));
    PlacedKeyframe& keyframe = island.keyframes[id];
    keyframe.parent = {};
    if (proto.parent().slot() != 0) {
      ASSIGN_OR_RETURN(keyframe.parent, slots.Keyframe(proto.parent()));
    }
    keyframe.place = proto;
    keyframe.place.clear_id();
    keyframe.place.clear_parent();
  }
  for (const v1::ItemRef& ref : changes.removed_keyframes()) {
    ASSIGN_OR_RETURN(const KeyframeId id, slots.Keyframe(ref));
    island.keyframes.erase(id);
  }
  return absl::OkStatus();
}

absl::Status MapMirror::ApplyPoints(const ProtoIsland& changes, const SlotReader& slots,
                                    Island& island) {
  ASSIGN_OR_RETURN(const std::vector<MapPointId> came,
                   slots.Points(changes.points().ids(), "points.ids"));
  const auto& positions = changes.points().positions();
  if (static_cast<size_t>(positions.size()) != 3 * came.size()) {
    return absl::InvalidArgumentError(absl::StrCat("points.positions has ", positions.size(),
                                                   " numbers for ", came.size(), " points"));
  }
  const auto& observations = changes.point_observations();
  if (!observations.empty() && static_cast<size_t>(observations.size()) != came.size()) {
    return absl::InvalidArgumentError(absl::StrCat("point_observations has ", observations.size(),
                                                   " numbers for ", came.size(), " points"));
  }
  tells_observations_ |= !observations.empty();
  for (size_t i = 0; i < came.size(); ++i) {
    const int at = static_cast<int>(3 * i);
    Point& point = island.points[came[i]];
    point.position = {positions.Get(at), positions.Get(at + 1), positions.Get(at + 2)};
    point.observations = observations.empty() ? 0 : observations.Get(static_cast<int>(i));
  }
  ASSIGN_OR_RETURN(const std::vector<MapPointId> went,
                   slots.Points(changes.removed_points(), "removed_points"));
  for (const MapPointId& id : went) island.points.erase(id);
  return absl::OkStatus();
}

bool MapMirror::TellKeyframes(Islands::const_reference entry, PictureCursor& cursor, size_t& room,
                              SlotWriter& slots, v1::WatchMapResponse& piece) const {
  const auto& [id, island] = entry;
  ProtoIsland* proto = BeginIsland(id, island.in_global_frame, island.local_maps, slots, piece);
  auto next = cursor.keyframe.IsValid() ? island.keyframes.upper_bound(cursor.keyframe)
                                        : island.keyframes.begin();
  for (; next != island.keyframes.end() && room > 0; ++next, --room) {
    Keyframe* keyframe = proto->add_keyframes();
    *keyframe = next->second.place;
    slots.Write(next->first, keyframe->mutable_id());
    if (next->second.parent.IsValid()) slots.Write(next->second.parent, keyframe->mutable_parent());
    cursor.keyframe = next->first;
  }
  return next == island.keyframes.end();
}

bool MapMirror::TellPoints(Islands::const_reference entry, PictureCursor& cursor, size_t& room,
                           SlotWriter& slots, v1::WatchMapResponse& piece) const {
  const auto& [id, island] = entry;
  ProtoIsland* proto = BeginIsland(id, island.in_global_frame, island.local_maps, slots, piece);
  IdColumnWriter ids(slots, proto->mutable_points()->mutable_ids());
  auto next =
      cursor.point.IsValid() ? island.points.upper_bound(cursor.point) : island.points.begin();
  for (; next != island.points.end() && room > 0; ++next, --room) {
    ids.Add(next->first);
    const Point& point = next->second;
    for (const float value : point.position) proto->mutable_points()->add_positions(value);
    if (tells_observations_) proto->add_point_observations(point.observations);
    cursor.point = next->first;
  }
  return next == island.points.end();
}

v1::WatchMapResponse MapMirror::NextPiece(bool with_points, size_t max_items,
                                          PictureCursor& cursor) const {
  v1::WatchMapResponse piece;
  piece.set_version(version_);
  piece.set_revision(revision_);
  SlotWriter slots(piece.mutable_local_maps());
  size_t room = std::max<size_t>(1, max_items);
  while (room > 0 && !cursor.ended) {
    const auto island = islands_.lower_bound(cursor.island);
    if (island == islands_.end()) {
      cursor = {.points_begun = true, .ended = cursor.points_begun || !with_points};
      continue;
    }
    // The island may have gone since the piece before.
    if (island->first != cursor.island) {
      cursor = {.points_begun = cursor.points_begun, .island = island->first};
    }
    const bool told = cursor.points_begun ? TellPoints(*island, cursor, room, slots, piece)
                                          : TellKeyframes(*island, cursor, room, slots, piece);
    if (told) {
      cursor = {.points_begun = cursor.points_begun, .island = {island->first.value + 1}};
    }
  }
  piece.set_continues(!cursor.ended);
  for (const uint64_t value : piece.local_maps()) {
    const auto agent = agents_.find(LocalMapId{value});
    piece.add_local_map_agents(agent == agents_.end() ? std::string() : agent->second);
  }
  return piece;
}

}  // namespace corbslam::services
