#include "map_store/archive/state_archive.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/str_cat.h"
#include "map_store/archive/state_fields.h"
#include "map_store/ingest/item_validation.h"
#include "map_store/records/state_validation.h"
#include "map_store/state/session_frames.h"
#include "map_store/view/placement.h"
#include "slam/coding/feature_coding.h"
#include "slam/coding/feature_columns.h"
#include "slam/map/map.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

// Holds a keyframe of the graph as lists, from which a Map is built again.
struct StoredKeyframe {
  std::shared_ptr<const KeyframePayload> payload;
  uint32_t keypoints = 0;
  Rigid3d camera_from_map;
  KeyframeId parent;
  std::vector<KeyframeId> loop_edges;
};
struct StoredPoint {
  MapPointId id;
  Eigen::Vector3d position_in_map = Eigen::Vector3d::Zero();
  KeyframeId reference;
  Descriptor descriptor;
  Eigen::Vector3d normal_in_map = Eigen::Vector3d::Zero();
  double min_distance = 0;
  double max_distance = 0;
  std::vector<std::pair<KeyframeId, uint32_t>> observations;
};
struct StoredMap {
  std::vector<StoredKeyframe> keyframes;
  std::vector<StoredPoint> points;
};

template <typename Archive, MayBeConst<StoredKeyframe> T>
void Fields(Archive& archive, T& keyframe) {
  archive(keyframe.payload, keyframe.keypoints, keyframe.camera_from_map, keyframe.parent,
          keyframe.loop_edges);
}
template <typename Archive, MayBeConst<StoredPoint> T>
void Fields(Archive& archive, T& point) {
  archive(point.id, point.position_in_map, point.reference, point.descriptor, point.normal_in_map,
          point.min_distance, point.max_distance, point.observations);
}
template <typename Archive, MayBeConst<StoredMap> T>
void Fields(Archive& archive, T& map) {
  archive(map.keyframes, map.points);
}
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

// Format 3 has no recorded cameras, which follow everything else; in format 4 points are placed in
// their islands and not in an anchor; in format 5 lenses have five numbers (value_fields.h); up to
// format 6 missions have no profile, and the store lets go of nothing; in format 7 profiles have no
// revision and no settings of robots, local maps stay as they are, and none is deleted; up to
// format 8 what agents that only localise say is not kept, nor in which order parts of local maps
// arrived.
constexpr uint32_t kOldestStateFormat = 3;
constexpr uint32_t kFirstWithAnchors = 5;
constexpr uint32_t kFirstWithProfile = 7;
constexpr uint32_t kFirstWithSettings = 8;
constexpr uint32_t kFirstWithJoined = 8;
constexpr uint32_t kFirstWithTracks = 9;
constexpr uint32_t kFirstWithArrivals = 9;
constexpr uint32_t kStateFormat = 9;

absl::Status Unreadable(absl::string_view what) {
  return absl::DataLossError(absl::StrCat(what, " can't be read: its bytes are damaged"));
}

StoredMap ToStored(const Map& map) {
  StoredMap stored;
  for (const auto& [id, keyframe] : map.keyframes()) {
    stored.keyframes.push_back({keyframe.payload,
                                static_cast<uint32_t>(keyframe.points.size()),
                                keyframe.camera_from_map,
                                keyframe.parent,
                                {keyframe.loop_edges.begin(), keyframe.loop_edges.end()}});
  }
  for (const auto& [id, point] : map.points()) {
    stored.points.push_back({point.id,
                             point.position_in_map,
                             point.reference,
                             point.descriptor,
                             point.normal_in_map,
                             point.min_distance,
                             point.max_distance,
                             {point.observations.begin(), point.observations.end()}});
  }
  return stored;
}

absl::Status DifferentCount(KeyframeId id) {
  return Unreadable(absl::StrCat("the number of keypoints of keyframe ", ToString(id)));
}

// Returns the payload with its features, which must be valid; without features if `load` is null.
absl::StatusOr<std::shared_ptr<const KeyframePayload>> WithFeatures(const StoredKeyframe& stored,
                                                                    const LocalMapState& local_map,
                                                                    const FeatureLoader& load) {
  const KeyframeId id = stored.payload->id;
  const uint32_t index = stored.payload->camera_index;
  if (index >= local_map.cameras.size()) {
    return Unreadable(absl::StrCat("camera of keyframe ", ToString(id)));
  }
  const std::shared_ptr<const Camera>& camera = local_map.cameras[index];
  auto payload = std::make_shared<KeyframePayload>(*stored.payload);
  payload->camera = camera;
  if (load == nullptr) return payload;
  ASSIGN_OR_RETURN(payload->features, load(id));
  if (payload->features.keypoints.size() != stored.keypoints) return DifferentCount(id);
  const absl::Status valid = ValidateFullKeyframe({payload, stored.camera_from_map, stored.parent},
                                                  *camera, MapStoreOptions::WithoutBatchLimits());
  if (!valid.ok()) return absl::DataLossError(valid.message());
  return MakeKeyframePayload(std::move(*payload));
}

absl::Status AddKeyframes(const std::vector<StoredKeyframe>& keyframes, const FeatureLoader& load,
                          LocalMapState* local_map) {
  for (const std::shared_ptr<const Camera>& camera : local_map->cameras) {
    if (const absl::Status valid = Validate(*camera); !valid.ok()) {
      return absl::DataLossError(valid.message());
    }
  }
  for (const StoredKeyframe& from : keyframes) {
    Keyframe keyframe;
    ASSIGN_OR_RETURN(keyframe.payload, WithFeatures(from, *local_map, load));
    keyframe.points.resize(from.keypoints);
    keyframe.camera_from_map = from.camera_from_map;
    if (!local_map->map.AddKeyframe(std::move(keyframe))) {
      return Unreadable(absl::StrCat("keyframe ", ToString(from.payload->id)));
    }
  }
  return absl::OkStatus();
}

bool AddEdges(const std::vector<StoredKeyframe>& keyframes, Map* map) {
  bool sound = true;
  for (const StoredKeyframe& keyframe : keyframes) {
    const KeyframeId id = keyframe.payload->id;
    if (keyframe.parent.IsValid()) sound &= map->SetParent(id, keyframe.parent);
    for (const KeyframeId& other : keyframe.loop_edges) {
      // Each edge is stored with both of its keyframes.
      if (id < other) sound &= map->AddLoopEdge(id, other);
    }
  }
  return sound;
}

absl::Status AddPoints(const std::vector<StoredPoint>& points, Map* map) {
  for (const StoredPoint& from : points) {
    const absl::Status valid =
        ValidateFullPoint({from.id, from.position_in_map, from.reference, from.descriptor,
                           from.normal_in_map, from.min_distance, from.max_distance});
    if (!valid.ok()) return absl::DataLossError(valid.message());
    MapPoint point;
    point.id = from.id;
    point.position_in_map = from.position_in_map;
    point.reference = from.reference;
    point.descriptor = from.descriptor;
    point.normal_in_map = from.normal_in_map;
    point.min_distance = from.min_distance;
    point.max_distance = from.max_distance;
    bool sound = map->AddPoint(std::move(point));
    for (const auto& [keyframe, keypoint] : from.observations) {
      sound &= map->AddObservation(from.id, keyframe, keypoint);
    }
    if (!sound) return Unreadable(absl::StrCat("point ", ToString(from.id)));
  }
  return absl::OkStatus();
}

absl::Status BuildMap(const StoredMap& stored, const FeatureLoader& load,
                      LocalMapState* local_map) {
  RETURN_IF_ERROR(AddKeyframes(stored.keyframes, load, local_map));
  if (!AddEdges(stored.keyframes, &local_map->map)) {
    return Unreadable(absl::StrCat("local map ", ToString(local_map->id)));
  }
  RETURN_IF_ERROR(AddPoints(stored.points, &local_map->map));
  for (const auto& [id, point] : local_map->map.points()) {
    local_map->followers.Add(point.reference, id);
  }
  return absl::OkStatus();
}

std::vector<uint32_t> CountKeypoints(const std::vector<FullKeyframe>& keyframes) {
  std::vector<uint32_t> counts;
  for (const FullKeyframe& keyframe : keyframes) {
    counts.push_back(static_cast<uint32_t>(keyframe.payload->features.keypoints.size()));
  }
  return counts;
}

absl::StatusOr<Features> LoadOrBlank(const FeatureLoader& load, KeyframeId id, uint32_t keypoints) {
  if (load != nullptr) return load(id);
  Features blank;
  blank.keypoints.resize(keypoints);
  blank.descriptors.resize(keypoints);
  return blank;
}

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

// This mark stands where plain features have their number of keypoints, which is never so large:
// coded features follow.
constexpr uint64_t kCodedMark = ~uint64_t{0};

bool SameBits(const Features& a, const Features& b) {
  const auto same = [](float x, float y) {
    return std::bit_cast<uint32_t>(x) == std::bit_cast<uint32_t>(y);
  };
  return a.descriptors == b.descriptors &&
         std::ranges::equal(a.keypoints, b.keypoints, [&](const Keypoint& k, const Keypoint& l) {
           return same(k.x_px, l.x_px) && same(k.y_px, l.y_px) &&
                  same(k.disparity_px, l.disparity_px) && same(k.angle_rad, l.angle_rad) &&
                  k.octave == l.octave;
         });
}

// Returns nullopt where coding would not keep every bit: features that never passed the wire are
// not rounded.
std::optional<std::string> CodeExactly(const KeyframePayload& payload) {
  if (const auto code = payload.code.lock()) return *code;
  FeatureColumns columns = ToColumns(payload.features);
  if (payload.camera == nullptr || !SameBits(FromColumns(columns), payload.features)) {
    return std::nullopt;
  }
  return corbslam::EncodeFeatures(columns, {static_cast<uint32_t>(payload.camera->width_px),
                                            static_cast<uint32_t>(payload.camera->height_px)});
}

absl::StatusOr<Features> DecodeCoded(std::string_view bytes) {
  absl::StatusOr<FeatureColumns> columns =
      corbslam::DecodeFeatures(bytes, std::numeric_limits<size_t>::max());
  if (columns.ok()) return FromColumns(*std::move(columns));
  return absl::DataLossError(
      absl::StrCat("a keyframe's features can't be read: ", columns.status().message()));
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

// Lists what follows everything else since the store lets go of keyframes and points.
template <typename Archive, typename State>
void RetiredFields(Archive& archive, State& state) {
  archive(state.global.stand_ins);
  for (const LocalMapId& id : state.order) {
    auto& local_map = state.local_maps.at(id);
    archive(local_map.retired_keyframes, local_map.faded_points);
  }
}

// Lists what follows that since local maps become parts of others, and are deleted.
template <typename Archive, typename State>
void JoinedFields(Archive& archive, State& state) {
  archive(state.forgotten);
  for (const LocalMapId& id : state.order) archive(state.local_maps.at(id).joined);
}

// Lists what follows that since agents that only localise have trajectories.
template <typename Archive, typename State>
void TrackFields(Archive& archive, State& state) {
  for (auto& [name, agent] : state.agents) archive(agent.track);
}

void ReadArrivals(ArchiveReader& reader, MissionState& state) {
  uint64_t gone = 0;
  std::map<uint64_t, LocalMapId> names;
  reader(gone, names);
  state.arrivals = ArrivalBook(gone, std::move(names));
}

// Anchors points of an older format, which are placed in their islands. Where no keyframe is placed
// that sees a point, the point is not placed any more.
void AnchorPoints(MissionState& state) {
  PlacedPoints anchored;
  for (const auto& [id, placed] : state.global.points) {
    const MapPoint* point = state.FindPoint(id);
    if (point == nullptr) continue;
    const auto there = Anchor(*point, placed.position_in_anchor, placed.revision, state.global,
                              state.global.keyframes);
    if (there.has_value()) anchored.emplace_hint(anchored.end(), id, *there);
  }
  state.global.points = std::move(anchored);
}

absl::Status SetAnchors(const std::vector<KeyframeId>& anchors, PlacedPoints& points) {
  if (anchors.size() != points.size()) return Unreadable("what a mission's points are anchored in");
  auto anchor = anchors.begin();
  for (auto& [id, placed] : points) placed.anchor = *anchor++;
  return absl::OkStatus();
}

constexpr uint32_t kNoAnchor = std::numeric_limits<uint32_t>::max();

// Names each point's anchor by its rank among the plan's keyframes.
std::string EncodeAnchors(const RevisionPlan& plan) {
  absl::flat_hash_map<KeyframeId, uint32_t> ranks;
  for (const auto& [id, placed] : plan.keyframes) ranks.emplace(id, ranks.size());
  std::vector<uint32_t> anchors;
  anchors.reserve(plan.points.size());
  for (const auto& [id, planned] : plan.points) {
    const auto rank = ranks.find(planned.anchor);
    anchors.push_back(rank == ranks.end() ? kNoAnchor : rank->second);
  }
  ArchiveWriter writer;
  writer(anchors);
  return writer.Take();
}

absl::Status SetAnchors(const std::vector<uint32_t>& anchors, RevisionPlan& plan) {
  std::vector<KeyframeId> keyframes;
  keyframes.reserve(plan.keyframes.size());
  for (const auto& [id, placed] : plan.keyframes) keyframes.push_back(id);
  const bool sound =
      anchors.size() == plan.points.size() && std::ranges::all_of(anchors, [&](uint32_t rank) {
        return rank == kNoAnchor || rank < keyframes.size();
      });
  if (!sound) return Unreadable("what a plan's points are anchored in");
  auto rank = anchors.begin();
  for (auto& [id, planned] : plan.points) {
    planned.anchor = *rank == kNoAnchor ? KeyframeId() : keyframes[*rank];
    ++rank;
  }
  return absl::OkStatus();
}

RevisionPlan* PlanOf(JournalRecord& record) {
  if (auto* fuse = std::get_if<FuseRecord>(&record)) return &fuse->plan;
  if (auto* adjust = std::get_if<AdjustRecord>(&record)) return &adjust->plan;
  return nullptr;
}

// Writes what follows the record's fields: formats that are older end there.
void WriteTail(const BatchRecord& record, ArchiveWriter& writer) {
  writer(CountKeypoints(record.batch->full_keyframes));
  // Records of journals before format 6 end here.
  writer(record.batch->recorded_cameras);
  // Records of journals before format 7 end here.
  writer(record.batch->points_follow);
}
void WriteTail(std::string_view anchors, ArchiveWriter& writer) {
  writer.Raw(anchors.data(), anchors.size());
}

}  // namespace

PlanBytes EncodePlan(const RevisionPlan& plan) {
  ArchiveWriter writer;
  writer(plan);
  return {writer.Take(), EncodeAnchors(plan)};
}

std::string EncodeFeatures(const KeyframePayload& payload) {
  ArchiveWriter writer;
  if (const std::optional<std::string> coded = CodeExactly(payload)) {
    writer(kCodedMark);
    writer.Raw(coded->data(), coded->size());
  } else {
    writer(payload.features);
  }
  return writer.Take();
}

absl::StatusOr<Features> DecodeFeatures(std::string_view bytes) {
  ArchiveReader reader(bytes);
  if (uint64_t mark = 0; bytes.size() >= sizeof(mark)) {
    std::memcpy(&mark, bytes.data(), sizeof(mark));
    if (mark == kCodedMark) return DecodeCoded(bytes.substr(sizeof(mark)));
  }
  Features features;
  reader(features);
  if (!reader.done() ||
      (!features.descriptors.empty() && features.descriptors.size() != features.keypoints.size())) {
    return Unreadable("a keyframe's features");
  }
  return features;
}

std::string EncodeRecord(const JournalRecord& record) {
  ArchiveWriter writer;
  writer(record);
  if (const auto* update = std::get_if<BatchRecord>(&record)) {
    WriteTail(*update, writer);
  } else if (const auto* fuse = std::get_if<FuseRecord>(&record)) {
    WriteTail(EncodeAnchors(fuse->plan), writer);
  } else if (const auto* adjust = std::get_if<AdjustRecord>(&record)) {
    WriteTail(
        adjust->plan_bytes != nullptr ? adjust->plan_bytes->anchors : EncodeAnchors(adjust->plan),
        writer);
  } else if (const auto* profile = std::get_if<ProfileRecord>(&record)) {
    NewerFields(writer, profile->profile);
  }
  return writer.Take();
}

absl::StatusOr<JournalRecord> DecodeRecord(std::string_view bytes, const FeatureLoader& load) {
  ArchiveReader reader(bytes);
  JournalRecord record;
  reader(record);
  auto* update = std::get_if<BatchRecord>(&record);
  std::vector<uint32_t> keypoints;
  std::vector<RecordedCamera> recorded_cameras;
  if (update != nullptr && reader.ok()) reader(keypoints);
  if (update != nullptr && reader.left() > 0) reader(recorded_cameras);
  bool points_follow = false;
  if (update != nullptr && reader.left() > 0) reader(points_follow);
  if (RevisionPlan* plan = PlanOf(record); plan != nullptr && reader.left() > 0) {
    std::vector<uint32_t> anchors;
    reader(anchors);
    RETURN_IF_ERROR(SetAnchors(anchors, *plan));
  }
  // Records of journals before format 13 end before.
  if (auto* profile = std::get_if<ProfileRecord>(&record);
      profile != nullptr && reader.left() > 0) {
    NewerFields(reader, profile->profile);
  }
  if (!reader.done()) return Unreadable("a journal record");
  if (update == nullptr) return record;
  auto batch = std::make_shared<MapUpdateBatch>(*update->batch);
  if (keypoints.size() != batch->full_keyframes.size()) return Unreadable("a journal record");
  batch->recorded_cameras = std::move(recorded_cameras);
  batch->points_follow = points_follow;
  for (size_t i = 0; i < keypoints.size(); ++i) {
    auto payload = std::make_shared<KeyframePayload>(*batch->full_keyframes[i].payload);
    ASSIGN_OR_RETURN(payload->features, LoadOrBlank(load, payload->id, keypoints[i]));
    if (payload->features.keypoints.size() != keypoints[i]) return DifferentCount(payload->id);
    batch->full_keyframes[i].payload = std::move(payload);
  }
  update->batch = std::move(batch);
  return record;
}

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
  NewerFields(writer, state.profile);
  JoinedFields(writer, state);
  TrackFields(writer, state);
  writer(state.arrivals.gone(), state.arrivals.names());
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
  if (!reader.ok() || format < kOldestStateFormat || format > kStateFormat) {
    return Unreadable("a mission's snapshot");
  }
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
    if (format > kOldestStateFormat) reader(local_map.recorded_cameras);
    RETURN_IF_ERROR(CheckRecordedCameras(local_map));
    local_map.recorded_cameras.resize(local_map.cameras.size());
  }
  if (format < kFirstWithAnchors) {
    AnchorPoints(state);
  } else {
    std::vector<KeyframeId> anchors;
    reader(anchors);
    RETURN_IF_ERROR(SetAnchors(anchors, state.global.points));
  }
  if (format >= kFirstWithProfile) {
    reader(state.profile);
    RetiredFields(reader, state);
  }
  if (format >= kFirstWithSettings) NewerFields(reader, state.profile);
  if (format >= kFirstWithJoined) JoinedFields(reader, state);
  if (format >= kFirstWithTracks) TrackFields(reader, state);
  IndexJoined(state);
  if (format >= kFirstWithArrivals) {
    ReadArrivals(reader, state);
  } else {
    BeginArrivals(state);
  }
  if (!reader.done()) return Unreadable("a mission's snapshot");
  RETURN_IF_ERROR(ValidateState(state));
  IndexPoints(state);
  for (auto& [id, local_map] : state.local_maps) NoteNewestOfSessions(local_map);
  return state;
}

}  // namespace corbslam::map_store
