// All that the store knows of one mission. These are plain values, guarded by whoever owns them
// (Mission).
#ifndef CORBSLAM_MAP_STORE_STATE_MISSION_STATE_H_
#define CORBSLAM_MAP_STORE_STATE_MISSION_STATE_H_

#include <algorithm>
#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "absl/container/btree_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/time/time.h"
#include "map_store/state/arrival_book.h"
#include "map_store/state/change_log.h"
#include "map_store/state/landmarks.h"
#include "map_store/state/localised_track.h"
#include "map_store/state/lookups.h"
#include "map_store/state/mission_profile.h"
#include "map_store/state/overlap_ledger.h"
#include "map_store/state/point_index.h"
#include "map_store/state/pose_table.h"
#include "map_store/state/query_queue.h"
#include "map_store/state/sights_table.h"
#include "map_store/state/told_memory.h"
#include "map_store/state/waiting_table.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/overlap.h"
#include "slam/exchange/point_followers.h"
#include "slam/exchange/uplink.h"
#include "slam/map/map.h"
#include "slam/place/keyframe_database.h"

namespace corbslam::map_store {

// What is left of a keyframe that its owner removed.
struct Tombstone {
  KeyframeId parent;
  Rigid3d parent_from_removed;
};

// References to items that have not arrived. `since` says when ExpireParked saw them first.
struct ParkedReference {
  std::variant<ObservationChange, LoopEdge> reference;
  absl::Time since = absl::InfiniteFuture();
};
struct ParkedParent {
  KeyframeId parent;
  absl::Time since = absl::InfiniteFuture();
};

// A closed local map that has become a part of another one of its agent (map_store/joining/). Its
// items keep their ids.
struct JoinedLocalMap {
  LocalMapId id;
  uint64_t last_batch = 0;
  // Where its frames begin among those of the whole.
  uint64_t first_frame = 0;
  uint64_t first_lost_frame = 0;
  // The same as LocalMapState's, for the session's own frames; derived by NoteNewestOfSessions.
  size_t newest_frame = 0;
  int64_t newest_lost_ns = std::numeric_limits<int64_t>::min();
};

// The local layer: one local map exactly as its owner last said it.
struct LocalMapState {
  LocalMapId id;
  std::string agent;
  size_t order = 0;  // Its place in the order of arrival in the mission.
  uint64_t last_batch = 0;
  bool closed = false;
  // Other local maps that have become parts of this one, in the order in which they did; and their
  // ids, derived from these. AddPart adds to both.
  std::vector<JoinedLocalMap> joined;
  absl::flat_hash_set<LocalMapId> part_names;

  std::vector<std::shared_ptr<const Camera>> cameras;
  // One for each camera; nullopt where the owner never said it.
  std::vector<std::optional<RecordedCamera>> recorded_cameras;
  // The local map's own keyframes and points, in its own frame. What its keyframes see of other
  // local maps' points is in `foreign_observations`: keyframe -> keypoint -> point.
  Map map;
  // The points of `map` that move with a keyframe; derived from `map`.
  PointFollowers followers;
  std::map<KeyframeId, absl::btree_map<uint32_t, MapPointId>> foreign_observations;
  std::vector<LoopEdge> foreign_loop_edges;

  // Items that the owner removed or replaced. Their ids never come back. Of removed points of parts
  // nothing is kept: nobody adds to a part.
  std::map<KeyframeId, Tombstone> removed_keyframes;
  std::set<MapPointId> removed_points;
  std::map<MapPointId, MapPointId> replaced_points;

  // How many keyframes came before each keyframe that ever arrived. The first `settled` are
  // settled.
  std::map<KeyframeId, size_t> arrival;
  std::vector<KeyframeId> arrived;
  size_t settled = 0;

  std::vector<TrackedFrame> frames;
  std::vector<int64_t> lost_frames_ns;
  // The frame of the latest time (its index in `frames`), and the latest time of a lost frame;
  // derived by NoteNewestFrames. Frames whose keyframes came late stand behind newer ones. Without
  // those of parts, whose clocks may be others.
  size_t newest_frame = 0;
  int64_t newest_lost_ns = std::numeric_limits<int64_t>::min();
  WaitingTable<uint64_t, ParkedReference> parked;         // By the order in which they came.
  WaitingTable<KeyframeId, ParkedParent> parked_parents;  // By child; the newest word counts.
  size_t expired_references = 0;
  // What StoredBytes counts, less what the store let go of.
  uint64_t stored_bytes = 0;
  // How many of the owner's keyframes and points the store itself let go of (retiring/): because
  // others stand in for them, and because later keyframes should have seen them and did not.
  uint64_t retired_keyframes = 0;
  uint64_t faded_points = 0;
  // Finds keyframes of `map` by their words.
  KeyframeDatabase database;
  // Changes for telling others, those of landmarks and foreign observations included; not those of
  // places.
  ChangeLog changes;
  // The mission's version at the last change by which keyframes of the local map may stand
  // elsewhere in their island. Not stored: a state that was read begins with its own pose tables.
  uint64_t places_version = 0;

  // Returns the recorded camera (docs/terminology.md); nullopt where the owner never said it.
  std::optional<RecordedCamera> Recorded(size_t camera_index = 0) const {
    if (camera_index >= recorded_cameras.size()) return std::nullopt;
    return recorded_cameras[camera_index];
  }
  // Returns its id, and those of the local maps that have become parts of it.
  std::vector<LocalMapId> Names() const {
    std::vector<LocalMapId> names = {id};
    for (const JoinedLocalMap& part : joined) names.push_back(part.id);
    return names;
  }
  bool IsNamed(LocalMapId name) const { return name == id || part_names.contains(name); }
  void AddPart(const JoinedLocalMap& part) {
    joined.push_back(part);
    part_names.insert(part.id);
  }
  size_t CountParked() const { return parked.size() + parked_parents.size(); }
  bool IsSettled(KeyframeId keyframe) const {
    const auto it = arrival.find(keyframe);
    return it != arrival.end() && it->second < settled;
  }
  // Returns whether so many newer keyframes have arrived, or none will.
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
  // The last revision by which it was seen to stand elsewhere (view/visible_motion.h), and where it
  // stood then; not stored.
  uint64_t moved_by = 0;
  Similarity3d shown_from_island = {};
};

using PlacedKeyframes = std::map<KeyframeId, PlacedKeyframe>;

// A position that fusion itself gave to a point. It is kept relative to a placed keyframe, the
// anchor, so that a revision that moves keyframes moves their points without naming them. Where the
// anchor is not placed any more, the point is not placed either (view/placement.h).
struct PlacedPoint {
  KeyframeId anchor;
  Eigen::Vector3d position_in_anchor = Eigen::Vector3d::Zero();
  // The one by which the point was seen to move; its anchor may have moved since.
  uint64_t revision = 0;
  // How far it may have moved in the anchor since then, in the anchor's units; not stored.
  double unseen_motion = 0;
};
using PlacedPoints = absl::btree_map<MapPointId, PlacedPoint>;

// What stands in for a keyframe that the store let go of: another one of the same island, of
// whatever local map.
struct StandIn {
  KeyframeId keyframe;
  Rigid3d keyframe_from_retired;
};

struct Island {
  IslandId id;
  // In the order of their arrival in the mission.
  std::vector<LocalMapId> local_maps;
  // Whether fusion has placed something in the island.
  bool fused = false;
  // Grows with every fusing; an adjustment of an older generation is worth nothing any more.
  uint64_t generation = 0;
  // Whether something came or moved since the last adjustment.
  bool dirty = false;
  bool needs_adjustment = false;
  size_t overlaps_since_adjustment = 0;
  // Placed keyframes whose owner has moved them since, relative to their parents.
  std::set<KeyframeId> displaced;
  // How many keyframes the island had at its last adjustment, and which of them overlaps have moved
  // since. Not recorded: after a backup is restored all keyframes count as new.
  size_t adjusted = 0;
  std::set<KeyframeId> moved;
  // Local maps whose owner closed a loop after they had been placed.
  std::set<LocalMapId> relaxed;
  uint64_t version = 0;            // The mission's version at its last change.
  uint64_t version_of_owners = 0;  // The same, of the last change that an owner made.
  // The same, of the last change that is worth telling the agents of.
  uint64_t shared_version = 0;
};

// Raw observations that fusion found to be wrong. Each is ignored as long as the owner says the
// same.
using RejectedObservations = std::map<std::pair<KeyframeId, uint32_t>, MapPointId>;
// The range of one keyframe's rejected observations.
class RejectedOf {
 public:
  RejectedOf(KeyframeId id, const RejectedObservations& rejected)
      : begin_(rejected.lower_bound({id, 0})),
        end_(rejected.upper_bound({id, std::numeric_limits<uint32_t>::max()})) {}
  RejectedObservations::const_iterator begin() const { return begin_; }
  RejectedObservations::const_iterator end() const { return end_; }
  bool empty() const { return begin_ == end_; }

 private:
  RejectedObservations::const_iterator begin_;
  RejectedObservations::const_iterator end_;
};

// Fusion's own estimates, beside what the owners say.
struct GlobalLayer {
  uint64_t revision = 0;
  PlacedKeyframes keyframes;
  PlacedPoints points;  // Of survivors and of points that are in no landmark.
  Landmarks landmarks;
  // The heir of each removed point: another point of the landmark that it was part of.
  std::map<MapPointId, MapPointId> heirs;
  RejectedObservations rejected;
  // What stands in for each keyframe that the store let go of. Where nothing does, as after the
  // island was dissolved, the tombstone counts, which is the owner's word.
  std::map<KeyframeId, StandIn> stand_ins;
  // Keyframes that fusion does without: they follow their relatives, and nobody is sent them.
  std::set<KeyframeId> culled;
  OverlapLedger overlaps;
  std::map<IslandId, Island> islands;
  std::map<LocalMapId, IslandId> island_of;
  // What people took back, which is not believed again: overlaps between two keyframes, and all
  // overlaps between two local maps. The lesser id of each pair stands first.
  std::set<std::pair<KeyframeId, KeyframeId>> taken_back;
  std::set<std::pair<LocalMapId, LocalMapId>> kept_apart;
  // Where a local map stands as a whole, for keyframes that have no placed relative left.
  std::map<LocalMapId, Similarity3d> island_from_local;
};

struct AgentState {
  std::vector<LocalMapId> local_maps;
  uint64_t session = 0;  // 0: not connected.
  // Which process of the agent holds that session (0: not known), since when, and from where.
  uint64_t instance = 0;
  absl::Time session_begin;
  std::string peer;
  // What it said of itself in sessions that change nothing.
  LocalisedTrack track;
  // True: that session changes nothing (SessionRequest::localise_only). Where it said last that it
  // is is not recorded: the newest frame with a pose, and the time of the newest one without.
  bool localise_only = false;
  std::optional<LocalisedFrame> localised;
  int64_t localised_lost_ns = -1;
};

struct MissionState {
  std::string name;
  // Tells the mission from earlier and later ones of its name (mission_uid.h); empty: it is older
  // than that, and has not been loaded since.
  std::string uid;
  MissionProfile profile;
  std::map<std::string, AgentState> agents;
  std::map<LocalMapId, LocalMapState> local_maps;
  std::vector<LocalMapId> order;  // Local maps as they arrived.
  // Local maps that are parts of others by now, by their old ids; derived from `joined` of these.
  // Ids go through it wherever a local map is looked up.
  std::map<LocalMapId, LocalMapId> joined_into;
  ArrivalBook arrivals;
  // The last batch of each local map that somebody deleted. Their ids never come back.
  std::map<LocalMapId, uint64_t> forgotten;
  GlobalLayer global;
  PointIndex points;  // Of the local maps' foreign observations and replacements, and of the heirs.
  PoseTables poses;   // The tables that were asked for lately (view/placement.h).
  SightsTable sights;  // What agents were told that keyframes see.
  ToldMemory told;
  QueryQueue queries;
  // How many queries were given up, by the local maps of query and candidates. Not recorded.
  std::map<std::pair<LocalMapId, LocalMapId>, uint64_t> failed_queries;
  uint64_t next_overlap = 1;
  // Grows with every change of either layer.
  uint64_t version = 0;
  MissionStatistics statistics;

  // Returns the local map that the named one is a part of now: mostly itself.
  LocalMapId OwnerOf(LocalMapId id) const {
    const auto it = joined_into.find(id);
    return it == joined_into.end() ? id : it->second;
  }
  // Returns null if it is unknown. One that has become a part of another is found as the whole.
  const LocalMapState* FindLocalMap(LocalMapId id) const {
    const auto it = local_maps.find(OwnerOf(id));
    return it == local_maps.end() ? nullptr : &it->second;
  }
  LocalMapState* FindLocalMap(LocalMapId id) {
    const auto it = local_maps.find(OwnerOf(id));
    return it == local_maps.end() ? nullptr : &it->second;
  }
  // Returns the keyframe as its owner has it; null if it is unknown or removed.
  const Keyframe* FindKeyframe(KeyframeId id) const {
    const LocalMapState* local_map = FindLocalMap(id.local_map);
    return local_map == nullptr ? nullptr : local_map->map.FindKeyframe(id);
  }
  const MapPoint* FindPoint(MapPointId id) const {
    const LocalMapState* local_map = FindLocalMap(id.local_map);
    return local_map == nullptr ? nullptr : local_map->map.FindPoint(id);
  }
  // Returns null if the local map is unknown.
  const Island* FindIslandOf(LocalMapId id) const {
    const auto it = global.island_of.find(id);
    return it == global.island_of.end() ? nullptr : &global.islands.at(it->second);
  }
  Island* FindIslandOf(LocalMapId id) {
    const auto it = global.island_of.find(id);
    return it == global.island_of.end() ? nullptr : &global.islands.at(it->second);
  }
  // Returns the island of the mission's first local map; invalid as long as there is none.
  IslandId ReferenceIsland() const {
    return order.empty() ? IslandId() : global.island_of.at(order.front());
  }
};

// Returns the living point that `point` stands for now: its owners' replacements are followed, then
// the landmark that it is part of. Invalid if it is unknown or removed.
MapPointId ResolvePoint(const MissionState& state, MapPointId point);
// Returns the point that a keyframe's keypoint sees according to the owner, which may be another
// local map's; invalid if it sees none.
MapPointId RawObservation(const LocalMapState& local_map, KeyframeId keyframe, uint32_t keypoint);

// Counts the keyframes of all local maps of the island.
size_t CountKeyframes(const MissionState& state, const Island& island);

// Returns the number of the last batch of the local map, also of one that has become a part of
// another or was deleted; 0 if it is unknown.
uint64_t LastBatchOf(const MissionState& state, LocalMapId id);
// Says that the local map, with all its parts, lies in the island.
void SetIslandOf(const LocalMapState& local_map, IslandId island, MissionState& state);
// Makes `joined_into` and the names of parts anew. The caller, who has read a state from somewhere,
// does so once.
void IndexJoined(MissionState& state);

// Makes `points` anew. The caller, who has read a state from somewhere, does so once.
void IndexPoints(MissionState& state);

// The caller says that all of the local map may have changed, and may stand elsewhere.
void ForgetChanges(const MissionState& state, LocalMapState& local_map);

// Brings `newest_frame` and `newest_lost_ns` up to date with frames that were appended after the
// first `tracked` and `lost` ones.
void NoteNewestFrames(size_t tracked, size_t lost, LocalMapState& local_map);

// Adds a local map of an agent, as an island of its own.
LocalMapState& AddLocalMap(MissionState& state, LocalMapId id, const std::string& agent);
// These note a change of an island: by a local map's owner, with whether other agents should hear
// of it, or by fusion. They close the change logs of the island's local maps.
void TouchByOwner(MissionState& state, LocalMapId local_map, bool share);
void TouchByFusion(MissionState& state, IslandId island);
// Notes that the store itself changed some of the island's local maps, of which others stand where
// they stood. Nothing is to be adjusted for that.
void TouchByRetirement(MissionState& state, IslandId island,
                       const std::set<LocalMapId>& local_maps);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_MISSION_STATE_H_
