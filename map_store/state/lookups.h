// What people and tools ask the map store for: plain answers, and lists in pages.
#ifndef CORBSLAM_MAP_STORE_STATE_LOOKUPS_H_
#define CORBSLAM_MAP_STORE_STATE_LOOKUPS_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/time/time.h"
#include "map_store/state/mission_profile.h"
#include "map_store/state/sights_table.h"
#include "slam/exchange/agent_report.h"
#include "slam/exchange/overlap.h"
#include "slam/geometry/rigid3.h"
#include "slam/map/keyframe.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// An island is named by its first local map; its frame is the island's frame.
using IslandId = LocalMapId;

struct PageRequest {
  size_t page_size = 0;    // 0: as many as the store allows.
  std::string page_token;  // The token in the answer before; empty: the first page.
};
template <typename T>
struct Page {
  std::vector<T> items;
  std::string next_page_token;  // Empty after the last page.
};

// Since when no fusion worker has taken the store's requests, and what the store heard instead.
struct WorkerOutage {
  absl::Time begin;
  std::string cause;
};

// How many keyframes of one local map were not looked up among those of another.
struct UncomparedPair {
  LocalMapId query;
  LocalMapId against;
  uint64_t waiting = 0;
  // Look-ups that were given up because workers answered with errors. Those before a restart are
  // not counted.
  uint64_t failed = 0;
};

struct MissionInfo {
  std::string name;
  std::string uid;  // MissionState::uid; empty: nobody knows it.
  uint64_t revision = 0;
  size_t agents = 0;
  size_t connected_agents = 0;
  size_t local_maps = 0;
  size_t islands = 0;
  size_t keyframes = 0;
  size_t map_points = 0;
  bool fusion_idle = true;
  // Look-ups of a keyframe in a local map that wait for a worker.
  uint64_t waiting_queries = 0;
  // Whether the store has fusion workers at all; they may be away.
  bool has_worker = false;
  std::optional<WorkerOutage> worker_outage;
  // About how much memory its map takes, and what it takes of the journal's disk.
  uint64_t memory_bytes = 0;
  uint64_t disk_bytes = 0;
  std::string damage;  // As Journal::Damage says it; empty: none.
  // With when a robot or a caller used it last; who asks for this is none.
  MissionProfile profile;
  // It is on the disk alone: the numbers above, but for `disk_bytes`, are those that it fell asleep
  // with.
  bool asleep = false;
};

// Where an agent was at its newest frame that had a pose, as far as the store was told. The newest
// is that of the latest time in the local map that was opened last and has any.
struct LastPose {
  int64_t timestamp_ns = 0;
  LocalMapId local_map;  // Invalid: of no local map, as the agent localises only.
  IslandId island;
  bool in_reference_island = false;
  // The pose of the keyframes' camera, whose units are rescaled to the island's.
  Rigid3d camera_from_island;
  // Frames of a later time, or of later local maps, had none.
  bool lost_since = false;
};

struct AgentInfo {
  std::string name;
  bool connected = false;
  std::vector<LocalMapId> local_maps;  // In the order in which they were opened.
  // Whether it is connected and nothing waits to be told to it.
  bool up_to_date = false;
  uint64_t shared_updates = 0;  // The number that its session was sent.
  // Its session changes nothing; `last_pose` is then what it said of itself.
  bool localise_only = false;
  std::optional<LastPose> last_pose;
  // What it last said of itself, and how long ago; nullopt: nothing since the mission was loaded.
  std::optional<AgentReport> report;
  absl::Duration report_age;
  // It is not connected, and ended its last session itself.
  bool left_on_purpose = false;
};

struct LocalMapInfo {
  LocalMapId id;
  std::string agent;
  // Which of the agent's local maps it is (ArrivalBook).
  uint64_t number = 0;
  IslandId island;
  bool in_reference_island = false;
  // Lengths in its own frame, and in its island's, are metres; or nothing is known of its camera
  // yet.
  bool in_metres = true;
  bool island_in_metres = true;
  bool closed = false;
  uint64_t last_batch = 0;
  size_t keyframes = 0;
  size_t settled_keyframes = 0;
  size_t placed_keyframes = 0;
  size_t map_points = 0;
  size_t tracked_frames = 0;
  size_t lost_frames = 0;
  size_t parked_references = 0;
  // What the store itself let go of (LocalMapState).
  uint64_t retired_keyframes = 0;
  // Closed local maps of the owner that have become parts of this one, and their numbers.
  std::vector<LocalMapId> joined;
  std::vector<uint64_t> joined_numbers;
  uint64_t faded_points = 0;
};

struct KeyframeInfo {
  KeyframeId id;
  std::string agent;
  Rigid3d camera_from_local;
  // `camera_from_island` is in the frame of this island.
  IslandId island;
  Similarity3d camera_from_island;
  bool placed = false;
  bool settled = false;
  uint64_t revision = 0;  // The revision that placed it; 0: none.
  KeyframeId parent;
  size_t keypoints = 0;
  size_t observed_points = 0;
  // What its keypoints see; only where that was asked for.
  Sights sights;
  std::shared_ptr<const KeyframePayload> payload;
};

// What the transport measured of one batch, for the statistics.
struct BatchTransfer {
  uint64_t full_keyframe_bytes = 0;
  uint64_t full_map_point_bytes = 0;
  uint64_t light_keyframe_bytes = 0;
  uint64_t light_map_point_bytes = 0;
};

struct TransferStatistics {
  uint64_t count = 0;
  uint64_t bytes = 0;
  double ms = 0;
};

struct GlobalAdjustmentStatistics {
  int keyframes = 0;
  int map_points = 0;
  int iterations = 0;
  double ms = 0;
};

struct MissionStatistics {
  uint64_t revision = 0;
  size_t islands = 0;
  // Keyframes and points (each landmark once) that are stored now.
  size_t keyframes = 0;
  size_t map_points = 0;
  TransferStatistics full_keyframes;
  TransferStatistics full_map_points;
  TransferStatistics light_keyframes;
  TransferStatistics light_map_points;
  // Keyframes that were queried, candidates that a worker looked at, and overlaps that were
  // accepted.
  uint64_t overlaps_queried = 0;
  uint64_t overlaps_verified = 0;
  uint64_t overlaps_accepted = 0;
  // Milliseconds from the verified overlap to the committed revision, for each fusing of two
  // islands.
  std::vector<double> merge_ms;
  std::vector<GlobalAdjustmentStatistics> global_adjustments;
  uint64_t failed_requests = 0;
  std::vector<UncomparedPair> uncompared;  // By ids; without pairs of which all is looked up.
};

enum class TrajectoryFrame { kLocal, kGlobal };

struct StoredPose {
  int64_t timestamp_ns = 0;
  LocalMapId local_map;
  // x_in_frame = frame_from_camera * x_in_camera, with scale 1: the camera's units are the frame's.
  Rigid3d frame_from_camera;
  // The island whose frame it is; for the global frame only.
  IslandId island;
  // Whether this pose is not connected to the one before it in time: tracking was lost in between,
  // or another local map or run began.
  bool after_gap = false;
  // The run of an agent that localised only; `local_map` is then invalid. 0: the frame is a local
  // map's.
  uint64_t run = 0;
};

struct AgentTrajectory {
  std::string agent;
  // All tracked frames, by local map, then by time; then those of runs that localised only.
  std::vector<StoredPose> poses;
  uint64_t dropped = 0;  // Frames of such runs that the store has no more (LocalisedTrack).
  // Times at which the agent had no pose; of such runs the two ends of each stretch.
  uint64_t lost = 0;
  // Frames that are not in `poses`: nobody knows any more where they were, or that is in a frame
  // that was not asked for.
  uint64_t left_out = 0;
};

struct OverlapInfo {
  uint64_t id = 0;  // Grows in the order of verification.
  Overlap overlap;
  // Whether the two keyframes are in one island, through this or another overlap.
  bool fused = false;
  uint64_t revision = 0;  // The revision that took it into the graph; 0: none.
  // Says, for people, what happened beyond the verdict: "waits for fusing", "worker failed: ...".
  std::string note;
  // Pixels of the query and of the candidate; only where one overlap was asked for.
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> matches;
};

struct OverlapFilter {
  std::optional<bool> accepted;
  LocalMapId local_map;  // Invalid: any.
};

// One island of the global map, for viewers and pictures.
struct IslandView {
  IslandId id;
  bool is_reference = false;
  std::vector<LocalMapId> local_maps;
  struct KeyframePlace {
    KeyframeId id;
    int64_t timestamp_ns = 0;
    Rigid3d camera_from_island;  // The camera's units are rescaled to the island's.
    KeyframeId parent;
    bool placed = false;
  };
  std::vector<KeyframePlace> keyframes;  // By id.
  struct Point {
    MapPointId id;
    Eigen::Vector3d position_in_island = Eigen::Vector3d::Zero();
    uint32_t observations = 0;
  };
  std::vector<Point> points;  // By id; each landmark once.
};

// A piece of what changed in the map since a version that a watcher saw. Versions grow with every
// change, revisions only with fusion's commits.
struct MapChanges {
  // The changes of one island; items that are not named are as they were.
  struct Island {
    IslandId id;
    bool is_reference = false;
    std::vector<LocalMapId> local_maps;
    std::vector<std::string> agents;  // The agent of each of `local_maps`.
    // Local maps that have become parts of these, whose names items keep, and each one's agent.
    std::vector<std::pair<LocalMapId, std::string>> parts;
    // All that the watcher knows of this island is void: all of it comes again.
    bool anew = false;
    std::vector<IslandView::KeyframePlace> keyframes;  // Keyframes that came, or stand elsewhere.
    std::vector<KeyframeId> removed_keyframes;
    // Points that came, or lie elsewhere in the island. Their observations are those by keyframes
    // of the local maps in which they were made.
    std::vector<IslandView::Point> points;
    // Points that went, or became part of another landmark.
    std::vector<MapPointId> removed_points;
  };

  // The version and revision that the watcher knows once it has the last piece.
  uint64_t version = 0;
  uint64_t revision = 0;
  bool continues = false;  // More pieces of this change follow.
  std::vector<Island> islands;
  // Islands that are no more (fused into others), with all that was in them.
  std::vector<IslandId> removed_islands;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_LOOKUPS_H_
