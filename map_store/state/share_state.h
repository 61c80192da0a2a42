// What one agent has been sent of the global layer.
#ifndef CORBSLAM_MAP_STORE_STATE_SHARE_STATE_H_
#define CORBSLAM_MAP_STORE_STATE_SHARE_STATE_H_

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "absl/container/btree_map.h"
#include "absl/container/btree_set.h"
#include "map_store/state/far_keyframes.h"
#include "map_store/state/lookups.h"
#include "map_store/state/pose_table.h"
#include "map_store/state/sights_table.h"
#include "slam/exchange/shared_update.h"
#include "slam/exchange/uplink.h"
#include "slam/geometry/rigid3.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

struct SentKeyframe {
  Similarity3d camera_from_global;
  // The motion that placed the points that follow the keyframe and that fusion has not placed.
  Similarity3d global_from_local;
  std::shared_ptr<const Sights> sights;
};

// Items that may be news to the agent: the store looks at them, and sends what is new.
struct ShareNews {
  absl::btree_set<KeyframeId> keyframes;
  absl::btree_set<KeyframeId> sights;
  absl::btree_set<MapPointId> points;
  absl::btree_set<MapPointId> landmarks;
  bool own_keyframes = false;
  // Fusion may have moved any of the points that were sent: from this point on they are still to be
  // looked at. None: only `points` are.
  std::optional<MapPointId> all_points_from;
  // How many of the agent's own landmarks the keyframes saw that the agent lacked, when they were
  // counted, and the mission's revision when that counting began.
  absl::btree_map<KeyframeId, int> own_landmarks;
  uint64_t counted_at_revision = 0;
};

struct ShareState {
  // What the agent wants to be told, as its newest session says. Of what it was sent under another
  // scope it keeps all, and is told what becomes of it.
  ShareScope scope;
  // The frame in which all of the below was sent; invalid: nothing was.
  IslandId island;
  LocalMapId local_map;  // Invalid: the agent localises only, and its frame is the island's.
  // Where an agent that localises only said it was: at most two places under made-up names, the
  // newest last.
  IslandPoses said_places;
  std::map<KeyframeId, SentKeyframe> keyframes;
  absl::btree_map<MapPointId, Eigen::Vector3d> points;
  absl::btree_map<MapPointId, std::vector<MapPointId>> landmarks;
  std::map<KeyframeId, OwnKeyframePose> own_keyframes;
  // Where the agent was told that its local map lies as a whole in the mission's global frame.
  std::optional<Similarity3d> global_from_local;

  // News that are not sent yet, and up to where the mission has been searched for news: its
  // version, its revision, and the local maps that the island had then.
  ShareNews news;
  uint64_t seen_version = 0;
  uint64_t seen_revision = 0;
  std::set<LocalMapId> seen_local_maps;
  // The scope is another since then: all is to be looked at as if it had never been seen.
  bool look_at_all = false;
  // Others' keyframes that are too far away to be sent (ShareMode::kNearby). They are no news.
  FarKeyframes far;
  // The island's `shared_version` up to which everything was sent.
  uint64_t complete_at_version = 0;
  // The revision of the last update, and how many updates had it.
  uint64_t last_revision = 0;
  int updates_of_last_revision = 0;
  bool restart = false;
  // What the last update said.
  bool more_places = false;
  // The last look ended before all that may be news was looked at.
  bool unfinished = false;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_SHARE_STATE_H_
