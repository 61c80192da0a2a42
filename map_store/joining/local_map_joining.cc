#include "map_store/joining/local_map_joining.h"

#include <algorithm>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

absl::Status Refused(const LocalMapJoining& joining, absl::string_view why) {
  return absl::FailedPreconditionError(absl::StrCat("local map ", ToString(joining.part),
                                                    " does not become a part of ",
                                                    ToString(joining.whole), ": ", why));
}

void MoveItems(const LocalMapJoining& joining, GlobalLayer& global, Map& map) {
  const Rigid3d part_from_whole = joining.whole_from_part.Inverse();
  std::vector<KeyframeId> keyframes;
  for (const auto& [id, keyframe] : map.keyframes()) keyframes.push_back(id);
  for (const KeyframeId& id : keyframes) {
    map.SetPose(id, map.FindKeyframe(id)->camera_from_map * part_from_whole);
    const auto placed = global.keyframes.find(id);
    if (placed == global.keyframes.end()) continue;
    Rigid3d& derived_from = placed->second.camera_from_local;
    derived_from = derived_from * part_from_whole;
  }
  std::vector<MapPointId> points;
  for (const auto& [id, point] : map.points()) points.push_back(id);
  for (const MapPointId& id : points) {
    const MapPoint point = *map.FindPoint(id);
    map.SetPosition(id, joining.whole_from_part * point.position_in_map);
    map.SetPointAppearance(id, point.descriptor,
                           joining.whole_from_part.rotation * point.normal_in_map,
                           point.min_distance, point.max_distance, point.reference);
  }
}

template <typename T>
void Append(std::vector<T>& from, std::vector<T>& to) {
  to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
}

// Parts of the part become parts of the whole, too.
void NotePart(const LocalMapState& part, LocalMapState& whole) {
  const uint64_t frames = whole.frames.size();
  const uint64_t lost = whole.lost_frames_ns.size();
  whole.AddPart(
      {part.id, part.last_batch, frames, lost, frames + part.newest_frame, part.newest_lost_ns});
  for (JoinedLocalMap inner : part.joined) {
    inner.first_frame += frames;
    inner.first_lost_frame += lost;
    inner.newest_frame += frames;
    whole.AddPart(inner);
  }
}

void TakeArrivals(const LocalMapState& part, LocalMapState& whole) {
  for (const KeyframeId& id : part.arrived) {
    whole.arrival[id] = whole.arrived.size();
    whole.arrived.push_back(id);
  }
  whole.settled = whole.arrived.size();
}

void TakeFrames(LocalMapState& part, LocalMapState& whole) {
  Append(part.frames, whole.frames);
  Append(part.lost_frames_ns, whole.lost_frames_ns);
}

void TakeGraph(LocalMapState& part, LocalMapState& whole) {
  for (const auto& [id, keyframe] : part.map.keyframes()) {
    if (keyframe.words != nullptr) whole.database.Add(id, keyframe.words);
  }
  for (const auto& [id, point] : part.map.points()) whole.followers.Add(point.reference, id);
  whole.map.Absorb(std::move(part.map));
  whole.foreign_observations.merge(part.foreign_observations);
  Append(part.foreign_loop_edges, whole.foreign_loop_edges);
  whole.removed_keyframes.merge(part.removed_keyframes);
  whole.replaced_points.merge(part.replaced_points);
  whole.expired_references += part.expired_references;
  whole.stored_bytes += part.stored_bytes;
  whole.retired_keyframes += part.retired_keyframes;
  whole.faded_points += part.faded_points;
}

// The part's old name is looked up as the whole from here on.
void ForgetPart(const LocalMapState& part, LocalMapId whole, MissionState& state) {
  const LocalMapId id = part.id;
  Island& island = *state.FindIslandOf(whole);
  std::erase(island.local_maps, id);
  if (island.relaxed.erase(id) > 0) island.relaxed.insert(whole);
  std::erase(state.agents.at(part.agent).local_maps, id);
  std::erase(state.order, id);
  for (size_t i = 0; i < state.order.size(); ++i) state.local_maps.at(state.order[i]).order = i;
  state.global.island_from_local.erase(id);
  state.poses.Add(id, nullptr);
  std::erase_if(state.failed_queries, [id](const auto& item) {
    return item.first.first == id || item.first.second == id;
  });
  for (const JoinedLocalMap& inner : part.joined) state.joined_into[inner.id] = whole;
  state.joined_into[id] = whole;
  state.local_maps.erase(id);
  // Jobs that run find a newer generation, and whoever reads in pieces a newer revision.
  ++island.generation;
  ++state.global.revision;
  const bool dirty = island.dirty;
  TouchByFusion(state, island.id);
  island.dirty = dirty;
  ForgetChanges(state, state.local_maps.at(whole));
}

}  // namespace

bool HaveSameCameras(const LocalMapState& a, const LocalMapState& b) {
  const auto same = [](const auto& x, const auto& y) { return *x == *y; };
  return std::ranges::equal(a.cameras, b.cameras, same) && a.recorded_cameras == b.recorded_cameras;
}

bool IsKeptApart(const LocalMapState& local_map, const GlobalLayer& global) {
  return std::ranges::any_of(global.kept_apart, [&local_map](const auto& pair) {
    return local_map.IsNamed(pair.first) || local_map.IsNamed(pair.second);
  });
}

bool StandsByItself(const LocalMapState& local_map, const GlobalLayer& global) {
  const auto& keyframes = local_map.map.keyframes();
  absl::flat_hash_map<KeyframeId, KeyframeId> root_of;
  const auto find_root = [&](const Keyframe& from) {
    std::vector<KeyframeId> way;
    const Keyframe* at = &from;
    while (!root_of.contains(at->id())) {
      way.push_back(at->id());
      const Keyframe* parent = local_map.map.FindKeyframe(at->parent);
      if (parent == nullptr) break;
      at = parent;
    }
    const auto known = root_of.find(at->id());
    const KeyframeId root = known == root_of.end() ? at->id() : known->second;
    for (const KeyframeId& id : way) root_of[id] = root;
    return root;
  };
  std::set<KeyframeId> placed_roots;
  for (const auto& [id, keyframe] : keyframes) {
    const KeyframeId root = find_root(keyframe);
    if (global.keyframes.contains(id)) placed_roots.insert(root);
  }
  return std::ranges::all_of(
      keyframes, [&](const auto& item) { return placed_roots.contains(root_of.at(item.first)); });
}

absl::Status CheckJoining(const LocalMapJoining& joining, const MissionState& state) {
  const auto part = state.local_maps.find(joining.part);
  const auto whole = state.local_maps.find(joining.whole);
  if (part == state.local_maps.end() || whole == state.local_maps.end()) {
    return Refused(joining, "one of them is not there");
  }
  const LocalMapState& a = part->second;
  const LocalMapState& b = whole->second;
  if (!a.closed || !b.closed) return Refused(joining, "one of them is not closed");
  if (a.agent != b.agent) return Refused(joining, "they are two agents'");
  if (a.order <= b.order) return Refused(joining, "it came first");
  const Island& island = *state.FindIslandOf(b.id);
  const bool joined = island.fused && state.FindIslandOf(a.id) == &island;
  if (!joined) return Refused(joining, "fusion has not joined them");
  if (island.id == a.id) return Refused(joining, "its island has its name");
  if (HaveSameCameras(a, b)) return absl::OkStatus();
  return Refused(joining, "their cameras differ");
}

absl::Status MayBecomePart(const LocalMapState& local_map, const MissionState& state) {
  const auto refused = [&local_map](absl::string_view why) {
    return absl::FailedPreconditionError(
        absl::StrCat("local map ", ToString(local_map.id), " becomes no part: ", why));
  };
  const Island& island = *state.FindIslandOf(local_map.id);
  if (island.id == local_map.id) return refused("its island has its name");
  if (local_map.CountParked() > 0) return refused("something that it refers to has not arrived");
  if (island.relaxed.contains(local_map.id)) return refused("a loop of it is to be welded");
  return absl::OkStatus();
}

absl::Status CheckMayJoin(const LocalMapJoining& joining, const MissionState& state) {
  RETURN_IF_ERROR(CheckJoining(joining, state));
  const LocalMapState& a = state.local_maps.at(joining.part);
  const LocalMapState& b = state.local_maps.at(joining.whole);
  RETURN_IF_ERROR(MayBecomePart(a, state));
  if (IsKeptApart(a, state.global) || IsKeptApart(b, state.global)) {
    return Refused(joining, "somebody keeps one of them apart from others");
  }
  if (StandsByItself(a, state.global) && StandsByItself(b, state.global)) return absl::OkStatus();
  return Refused(joining, "keyframes of one of them are placed through others of no relation");
}

void ApplyJoining(const LocalMapJoining& joining, MissionState& state) {
  LocalMapState& part = state.local_maps.at(joining.part);
  LocalMapState& whole = state.local_maps.at(joining.whole);
  MoveItems(joining, state.global, part.map);
  NotePart(part, whole);
  TakeArrivals(part, whole);
  TakeFrames(part, whole);
  TakeGraph(part, whole);
  ForgetPart(part, whole.id, state);
}

}  // namespace corbslam::map_store
