// What one agent has been sent of the global layer.
#ifndef CORBSLAM_MAP_STORE_SHARE_STATE_H_
#define CORBSLAM_MAP_STORE_SHARE_STATE_H_

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "map_store/lookups.h"
#include "slam/geometry/rigid3.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

struct SentKeyframe {
  Similarity3d camera_from_global;
  // Keypoint and landmark, by keypoint.
  std::vector<std::pair<uint32_t, MapPointId>> points;
};

struct ShareState {
  // The frame in which all of the below was sent; invalid: nothing was.
  IslandId island;
  LocalMapId local_map;
  std::map<KeyframeId, SentKeyframe> keyframes;
  std::map<MapPointId, Eigen::Vector3d> points;
  std::map<MapPointId, std::vector<MapPointId>> landmarks;
  std::map<KeyframeId, Similarity3d> own_keyframes;

  // Up to where all was sent: the island's version that was worth telling, the mission's version,
  // the revision, and the local maps that the island had then.
  uint64_t complete_at_version = 0;
  uint64_t seen_version = 0;
  uint64_t seen_revision = 0;
  std::set<LocalMapId> seen_local_maps;
  // The last update and how many had its revision.
  uint64_t last_revision = 0;
  int updates_of_last_revision = 0;
  bool restart = false;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_SHARE_STATE_H_
