// All that the store knows of one mission: plain values, guarded by whoever owns them (Mission).
#ifndef CORBSLAM_MAP_STORE_STATE_MISSION_STATE_H_
#define CORBSLAM_MAP_STORE_STATE_MISSION_STATE_H_

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "absl/container/btree_map.h"
#include "absl/time/time.h"
#include "map_store/state/change_log.h"
#include "map_store/state/landmarks.h"
#include "map_store/state/lookups.h"
#include "map_store/state/overlap_ledger.h"
#include "map_store/state/point_index.h"
#include "map_store/state/pose_table.h"
#include "map_store/state/query_queue.h"
#include "map_store/state/sights_table.h"
#include "map_store/state/waiting_table.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/overlap.h"
#include "slam/exchange/point_followers.h"
#include "slam/map/map.h"
#include "slam/place/keyframe_database.h"

namespace corbslam::map_store {

// What is left of a keyframe that its owner removed.
struct Tombstone {
  KeyframeId parent;
  Rigid3d parent_from_removed;
};

// References to what has not arrived. Since when they wait, as ExpireParked first saw them.
struct ParkedReference {
  std::variant<ObservationChange, LoopEdge> reference;
  absl::Time since = absl::InfiniteFuture();
};
struct ParkedParent {
  KeyframeId parent;
  absl::Time since = absl::InfiniteFuture();
};

// The local layer: one local map exactly as its owner last said it.
struct LocalMapState {
  LocalMapId id;
  std::string agent;
  size_t order = 0;  // Of arrival in the mission.
  uint64_t last_batch = 0;
  bool closed = false;

  std::vector<std::shared_ptr<const Camera>> cameras;
  // As many; nullopt where the owner never said it.
  std::vector<std::optional<RecordedCamera>> recorded_cameras;
  // Its own keyframes and points in its own frame. What its keyframes see of other local maps'
  // points stands beside it: keyframe -> keypoint -> point.
  Map map;
  // What of it moves with a keyframe; derived from it.
  PointFollowers followers;
  std::map<KeyframeId, std::map<uint32_t, MapPointId>> foreign_observations;
  std::vector<LoopEdge> foreign_loop_edges;

  // Ids never come back.
  std::map<KeyframeId, Tombstone> removed_keyframes;
  std::set<MapPointId> removed_points;
  std::map<MapPointId, MapPointId> replaced_points;

  // Of all keyframes that ever arrived: how many came before. The first `settled` are settled.
  std::map<KeyframeId, size_t> arrival;
  std::vector<KeyframeId> arrived;
  size_t settled = 0;

  std::vector<TrackedFrame> frames;
  std::vector<int64_t> lost_frames_ns;
  WaitingTable<uint64_t, ParkedReference> parked;         // By the order in which they came.
  WaitingTable<KeyframeId, ParkedParent> parked_parents;  // By child; the newest word counts.
  size_t expired_references = 0;
  uint64_t stored_bytes = 0;  // As StoredBytes counts them.
  // Words -> keyframes of `map`.
  KeyframeDatabase database;
  // For telling others. Landmarks and foreign observations included; places are not.
  ChangeLog changes;
  // The mission's version when something changed last by which its keyframes stand where they do in
  // their island. Not stored: a state that was read begins with tables of its own.
  uint64_t places_version = 0;

  // Of the camera that took the frames; nullopt where the owner never said it.
  std::optional<RecordedCamera> Recorded(size_t camera_index = 0) const {
    if (camera_index >= recorded_cameras.size()) return std::nullopt;
    return recorded_cameras[camera_index];
  }
  size_t CountParked() const { return parked.size() + parked_parents.size(); }
  bool IsSettled(KeyframeId keyframe) const {
    const auto it = arrival.find(keyframe);
    return it != arrival.end() && it->second < settled;
  }
  // So many newer ones have arrived, or none will.
  bool IsFollowedBy(size_t newer, KeyframeId keyframe) const {
    const auto it = arrival.find(keyframe);
    return it != arrival.end() && (closed || it->second + newer < arrived.size());
  }
};

// A pose that fusion itself gave to a keyframe.
struct PlacedKeyframe {
  Similarity3d camera_from_island;
  Rigid3d camera_from_local;  // The local pose from which it was derived.
  uint64_t revision = 0;
};

using PlacedKeyframes = std::map<KeyframeId, PlacedKeyframe>;

struct PlacedPoint {
  Eigen::Vector3d position_in_island = Eigen::Vector3d::Zero();
  uint64_t revision = 0;
};
using PlacedPoints = absl::btree_map<MapPointId, PlacedPoint>;

struct Island {
  IslandId id;
  // In the order of their arrival in the mission.
  std::vector<LocalMapId> local_maps;
  // Something in it was placed by fusion.
  bool fused = false;
  // Grows with every fusing; an adjustment of an older one is worth nothing any more.
  uint64_t generation = 0;
  // Something came or moved since the last adjustment.
  bool dirty = false;
  bool needs_adjustment = false;
  size_t overlaps_since_adjustment = 0;
  // Placed keyframes whose owner has moved them since, relative to their parents.
  std::set<KeyframeId> displaced;
  // Keyframes that it had then, and those that overlaps have moved since. Not recorded: after a
  // backup is restored all are new.
  size_t adjusted = 0;
  std::set<KeyframeId> moved;
  // Local maps whose owner closed a loop after they had been placed.
  std::set<LocalMapId> relaxed;
  uint64_t version = 0;            // Of the last change.
  uint64_t version_of_owners = 0;  // Of the last change that an owner made.
  // Of the last change that is worth telling the agents of.
  uint64_t shared_version = 0;
};

// A raw observation that fusion found to be wrong: ignored as long as the owner says the same.
using RejectedObservations = std::map<std::pair<KeyframeId, uint32_t>, MapPointId>;

// Fusion's own estimates, beside what the owners say.
struct GlobalLayer {
  uint64_t revision = 0;
  PlacedKeyframes keyframes;
  PlacedPoints points;  // Of survivors and lone points.
  Landmarks landmarks;
  // Removed points, and another of the landmark that each was part of.
  std::map<MapPointId, MapPointId> heirs;
  RejectedObservations rejected;
  // Keyframes that fusion does without: they follow their relatives, and nobody is sent them.
  std::set<KeyframeId> culled;
  OverlapLedger overlaps;
  std::map<IslandId, Island> islands;
  std::map<LocalMapId, IslandId> island_of;
  // What people took back, which is not believed again: overlaps between two keyframes, and all
  // between two local maps. The lesser id stands first.
  std::set<std::pair<KeyframeId, KeyframeId>> taken_back;
  std::set<std::pair<LocalMapId, LocalMapId>> kept_apart;
  // Where a local map stands as a whole, for what has no placed relative left.
  std::map<LocalMapId, Similarity3d> island_from_local;
};

struct AgentState {
  std::vector<LocalMapId> local_maps;
  uint64_t session = 0;  // 0: not connected.
  // Of that session: which process of the agent holds it (0: not known), since when, from where.
  uint64_t instance = 0;
  absl::Time session_begin;
  std::string peer;
};

struct MissionState {
  std::string name;
  std::map<std::string, AgentState> agents;
  std::map<LocalMapId, LocalMapState> local_maps;
  std::vector<LocalMapId> order;  // Local maps as they arrived.
  GlobalLayer global;
  PointIndex points;  // Of the local maps' foreign observations and replacements, and of the heirs.
  PoseTables poses;   // What was asked for lately (view/placement.h).
  SightsTable sights;  // What agents were told that keyframes see.
  QueryQueue queries;
  // How many of them were given up, by the local maps of query and candidates. Not recorded.
  std::map<std::pair<LocalMapId, LocalMapId>, uint64_t> failed_queries;
  uint64_t next_overlap = 1;
  // Grows with every change of either layer.
  uint64_t version = 0;
  MissionStatistics statistics;

  const LocalMapState* FindLocalMap(LocalMapId id) const {
    const auto it = local_maps.find(id);
    return it == local_maps.end() ? nullptr : &it->second;
  }
  LocalMapState* FindLocalMap(LocalMapId id) {
    const auto it = local_maps.find(id);
    return it == local_maps.end() ? nullptr : &it->second;
  }
  // The keyframe as its owner has it; null when unknown or removed.
  const Keyframe* FindKeyframe(KeyframeId id) const {
    const LocalMapState* local_map = FindLocalMap(id.local_map);
    return local_map == nullptr ? nullptr : local_map->map.FindKeyframe(id);
  }
  const MapPoint* FindPoint(MapPointId id) const {
    const LocalMapState* local_map = FindLocalMap(id.local_map);
    return local_map == nullptr ? nullptr : local_map->map.FindPoint(id);
  }
  // Null when the local map is unknown.
  const Island* FindIslandOf(LocalMapId id) const {
    const auto it = global.island_of.find(id);
    return it == global.island_of.end() ? nullptr : &global.islands.at(it->second);
  }
  Island* FindIslandOf(LocalMapId id) {
    const auto it = global.island_of.find(id);
    return it == global.island_of.end() ? nullptr : &global.islands.at(it->second);
  }
  // The mission's first local map's; invalid before that.
  IslandId ReferenceIsland() const {
    return order.empty() ? IslandId() : global.island_of.at(order.front());
  }
};

// The living point that `point` now stands for: through its owner's replacements and the landmark
// that it is part of. Invalid when it is unknown or removed.
MapPointId ResolvePoint(const MissionState& state, MapPointId point);
// What the owner says keypoint `keypoint` of a keyframe sees, its own point or another's; invalid
// for none.
MapPointId RawObservation(const LocalMapState& local_map, KeyframeId keyframe, uint32_t keypoint);

// Of all its local maps.
size_t CountKeyframes(const MissionState& state, const Island& island);

// Makes `points` anew; who reads a state from somewhere does so once.
void IndexPoints(MissionState& state);

// All of the local map may have changed, and stand elsewhere.
void ForgetChanges(const MissionState& state, LocalMapState& local_map);

// Adds a local map of an agent, as an island of its own.
LocalMapState& AddLocalMap(MissionState& state, LocalMapId id, const std::string& agent);
// Notes a change of the local map's island by its owner, and whether other agents should hear of
// it; and one by fusion. Closes the change logs of the island's local maps.
void TouchByOwner(MissionState& state, LocalMapId local_map, bool share);
void TouchByFusion(MissionState& state, IslandId island);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_MISSION_STATE_H_
