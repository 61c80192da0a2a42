#include "map_store/archive/state_archive.h"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/archive/formats.h"
#include "map_store/archive/state_fields.h"
#include "map_store/archive/stored_map.h"
#include "map_store/archive/unreadable.h"
#include "map_store/records/state_validation.h"
#include "map_store/state/session_frames.h"
#include "slam/map/map.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

template <typename Archive, MayBeConst<LocalMapState> T>
void Fields(Archive& archive, T& local_map) {
  archive(local_map.id, local_map.agent, local_map.order, local_map.last_batch, local_map.closed,
          local_map.cameras, local_map.foreign_observations, local_map.foreign_loop_edges,
          local_map.removed_keyframes, local_map.removed_points, local_map.replaced_points,
          local_map.arrival, local_map.arrived, local_map.settled, local_map.frames,
          local_map.lost_frames_ns, local_map.parked, local_map.parked_parents,
          local_map.expired_references, local_map.stored_bytes);
}
template <typename Archive, MayBeConst<AgentState> T>
void Fields(Archive& archive, T& agent) {
  archive(agent.local_maps);
}

namespace {

absl::Status CheckRecordedCameras(const LocalMapState& local_map) {
  if (local_map.recorded_cameras.size() > local_map.cameras.size()) {
    return Unreadable(absl::StrCat("local map ", ToString(local_map.id)));
  }
  for (const std::optional<RecordedCamera>& recorded : local_map.recorded_cameras) {
    const absl::Status valid = recorded.has_value() ? Validate(*recorded) : absl::OkStatus();
    if (!valid.ok()) return absl::DataLossError(valid.message());
  }
  return absl::OkStatus();
}

// Lists the fields in the order in which DecodeState reads them; writing has the same order.
template <typename Archive, typename State>
void GlobalFields(Archive& archive, State& state) {
  auto& global = state.global;
  archive(state.name, state.agents, state.order, state.queries, state.next_overlap, state.version,
          state.statistics, global.revision, global.keyframes, global.points, global.heirs,
          global.rejected, global.culled, global.overlaps, global.islands, global.island_of,
          global.island_from_local, global.taken_back, global.kept_apart);
}

// Lists what the store has let go of.
template <typename Archive, typename State>
void RetiredFields(Archive& archive, State& state) {
  archive(state.global.stand_ins);
  for (const LocalMapId& id : state.order) {
    auto& local_map = state.local_maps.at(id);
    archive(local_map.retired_keyframes, local_map.faded_points);
  }
}

// Lists which local maps were deleted, and which became parts of others.
template <typename Archive, typename State>
void JoinedFields(Archive& archive, State& state) {
  archive(state.forgotten);
  for (const LocalMapId& id : state.order) archive(state.local_maps.at(id).joined);
}

// Lists the trajectories of agents that only localise.
template <typename Archive, typename State>
void TrackFields(Archive& archive, State& state) {
  for (auto& [name, agent] : state.agents) archive(agent.track);
}

// Numbers each agent's local maps, for a state of the format before: those that are deleted are
// not counted.
std::map<std::string, std::vector<LocalMapId>> NamesOfAgents(
    const std::map<uint64_t, LocalMapId>& names, const MissionState& state) {
  std::map<std::string, std::vector<LocalMapId>> of_agents;
  for (const auto& [number, name] : names) {
    const LocalMapState* local_map = state.FindLocalMap(name);
    if (local_map != nullptr) of_agents[local_map->agent].push_back(name);
  }
  return of_agents;
}

void ReadArrivals(ArchiveReader& reader, MissionState& state) {
  uint64_t gone = 0;
  std::map<uint64_t, LocalMapId> names;
  reader(gone, names);
  std::map<std::string, std::vector<LocalMapId>> of_agents = NamesOfAgents(names, state);
  state.arrivals = ArrivalBook(gone, std::move(names), std::move(of_agents));
}

void ReadNumbers(ArchiveReader& reader, MissionState& state) {
  std::map<std::string, std::vector<LocalMapId>> of_agents;
  reader(of_agents);
  const ArrivalBook& read = state.arrivals;
  state.arrivals = ArrivalBook(read.gone(), read.names(), std::move(of_agents));
}

absl::Status CheckStateFormat(uint32_t format) {
  if (format >= kOldestStateFormat && format <= kStateFormat) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat(
      "a mission's snapshot has format ", format, ", this program reads ", kOldestStateFormat,
      " to ", kStateFormat, format < kOldestStateFormat ? kHowToReadOlder : ""));
}

absl::Status SetAnchors(const std::vector<KeyframeId>& anchors, PlacedPoints& points) {
  if (anchors.size() != points.size()) return Unreadable("what a mission's points are anchored in");
  auto anchor = anchors.begin();
  for (auto& [id, placed] : points) placed.anchor = *anchor++;
  return absl::OkStatus();
}

}  // namespace

std::string EncodeState(const MissionState& state) {
  ArchiveWriter writer;
  writer(kStateFormat);
  GlobalFields(writer, state);
  writer(state.global.landmarks.sets());
  for (const LocalMapId& id : state.order) {
    const LocalMapState& local_map = *state.FindLocalMap(id);
    writer(local_map, ToStored(local_map.map));
  }
  for (const LocalMapId& id : state.order) writer(state.FindLocalMap(id)->recorded_cameras);
  std::vector<KeyframeId> anchors;
  for (const auto& [id, placed] : state.global.points) anchors.push_back(placed.anchor);
  writer(anchors, state.profile);
  RetiredFields(writer, state);
  SettingsFields(writer, state.profile);
  JoinedFields(writer, state);
  TrackFields(writer, state);
  writer(state.arrivals.gone(), state.arrivals.names());
  writer(state.uid, state.arrivals.of_agents());
  return writer.Take();
}

JournalSnapshot TakeSnapshot(const MissionState& state) {
  JournalSnapshot snapshot{0, EncodeState(state), {}};
  for (const auto& [id, local_map] : state.local_maps) {
    for (const auto& [keyframe, item] : local_map.map.keyframes()) {
      snapshot.keyframes.push_back(keyframe);
    }
  }
  return snapshot;
}

absl::StatusOr<MissionState> DecodeState(std::string_view bytes, const FeatureLoader& load) {
  ArchiveReader reader(bytes);
  uint32_t format = 0;
  reader(format);
  if (!reader.ok()) return Unreadable("a mission's snapshot");
  RETURN_IF_ERROR(CheckStateFormat(format));
  MissionState state;
  GlobalFields(reader, state);
  Landmarks::Sets landmarks;
  reader(landmarks);
  for (const auto& [survivor, members] : landmarks) {
    for (const MapPointId& member : members) state.global.landmarks.Merge(survivor, member);
  }
  for (const LocalMapId& id : state.order) {
    LocalMapState local_map;
    StoredMap stored;
    reader(local_map, stored);
    if (!reader.ok() || local_map.id != id) return Unreadable("a mission's snapshot");
    RETURN_IF_ERROR(BuildMap(stored, load, &local_map));
    state.local_maps.emplace(id, std::move(local_map));
  }
  for (const LocalMapId& id : state.order) {
    LocalMapState& local_map = *state.FindLocalMap(id);
    reader(local_map.recorded_cameras);
    RETURN_IF_ERROR(CheckRecordedCameras(local_map));
    local_map.recorded_cameras.resize(local_map.cameras.size());
  }
  std::vector<KeyframeId> anchors;
  reader(anchors);
  RETURN_IF_ERROR(SetAnchors(anchors, state.global.points));
  reader(state.profile);
  RetiredFields(reader, state);
  SettingsFields(reader, state.profile);
  JoinedFields(reader, state);
  TrackFields(reader, state);
  IndexJoined(state);
  ReadArrivals(reader, state);
  reader(state.uid);
  if (format >= kFirstStateWithNumbers) ReadNumbers(reader, state);
  if (!reader.done()) return Unreadable("a mission's snapshot");
  RETURN_IF_ERROR(ValidateState(state));
  IndexPoints(state);
  for (auto& [id, local_map] : state.local_maps) NoteNewestOfSessions(local_map);
  return state;
}

}  // namespace corbslam::map_store
