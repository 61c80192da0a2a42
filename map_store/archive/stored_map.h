// Holds a local map's graph as lists, which are archived.
#ifndef CORBSLAM_MAP_STORE_ARCHIVE_STORED_MAP_H_
#define CORBSLAM_MAP_STORE_ARCHIVE_STORED_MAP_H_

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "map_store/archive/feature_archive.h"
#include "map_store/archive/state_fields.h"
#include "map_store/state/mission_state.h"
#include "slam/map/map.h"

namespace corbslam::map_store {

// Together with its features, a keyframe from which a Map is built again.
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
StoredMap ToStored(const Map& map);
// Fills the graph of a local map of which everything else has been read. Returns DATA_LOSS, naming
// the item, where it is not sound or `load` gives features that are not its own; without features
// if `load` is null, and then it believes that the graph is a sound mission's.
absl::Status BuildMap(const StoredMap& stored, const FeatureLoader& load, LocalMapState* local_map);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ARCHIVE_STORED_MAP_H_
