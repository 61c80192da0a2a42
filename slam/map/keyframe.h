// A keyframe: an immutable payload (what the camera saw) and its mutable place in the graph.
#ifndef CORBSLAM_SLAM_MAP_KEYFRAME_H_
#define CORBSLAM_SLAM_MAP_KEYFRAME_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/container/btree_map.h"
#include "absl/container/btree_set.h"
#include "slam/camera/camera.h"
#include "slam/features/keypoint.h"
#include "slam/geometry/rigid3.h"
#include "slam/map/feature_grid.h"
#include "slam/util/ids.h"
#include "slam/vocabulary/words.h"

namespace corbslam {

// A payload is never edited once made; threads, maps and revisions share it.
struct KeyframePayload {
  KeyframeId id = {};
  // Time by the agent's own clock, which is never compared with another agent's.
  int64_t timestamp_ns = 0;
  // Index of the camera among those of its local map.
  uint32_t camera_index = 0;
  std::shared_ptr<const Camera> camera = {};
  // Undistorted pixels. Descriptors are empty where an algorithm needs none (bundle adjustment).
  Features features = {};
  // Finds keypoints by pixel; built from `features` by MakeKeyframePayload.
  FeatureGrid grid = {};
  // The code that `features` were read from (slam/coding/feature_coding.h), while whoever received
  // it keeps it: then nobody need code them again.
  std::weak_ptr<const std::string> code = {};
};

// The grid is built here; all the rest is taken as it is.
std::shared_ptr<const KeyframePayload> MakeKeyframePayload(KeyframePayload payload);
std::shared_ptr<const KeyframePayload> MakeKeyframePayload(KeyframeId id, int64_t timestamp_ns,
                                                           uint32_t camera_index,
                                                           std::shared_ptr<const Camera> camera,
                                                           Features features);
// The same payload but for its features, of which there is no code then; or but for its camera.
std::shared_ptr<const KeyframePayload> WithFeatures(const KeyframePayload& payload,
                                                    Features features);
std::shared_ptr<const KeyframePayload> WithCamera(const KeyframePayload& payload,
                                                  std::shared_ptr<const Camera> camera);

struct Keyframe {
  std::shared_ptr<const KeyframePayload> payload;
  // Words that the holder of the map computed with its own vocabulary; null until then. They are
  // never on the wire.
  std::shared_ptr<const Words> words;
  // The frame is the map's: a local map's own, or an island's.
  Rigid3d camera_from_map;

  // The points seen, one entry a keypoint; an invalid id where the keypoint observes no map point.
  std::vector<MapPointId> points;
  // Number of map points observed together with each other keyframe; kept by Map.
  absl::btree_map<KeyframeId, int> covisible;
  // The spanning tree. The root, and only the root, has an invalid parent.
  KeyframeId parent;
  absl::btree_set<KeyframeId> children;
  absl::btree_set<KeyframeId> loop_edges;

  KeyframeId id() const { return payload->id; }
  const Camera& camera() const { return *payload->camera; }
  const std::vector<Keypoint>& keypoints() const { return payload->features.keypoints; }
  const std::vector<Descriptor>& descriptors() const { return payload->features.descriptors; }
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_MAP_KEYFRAME_H_
