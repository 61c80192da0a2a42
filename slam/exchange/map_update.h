// What an agent tells the map store of its local map: numbered batches of full and light items and
// of changes to the graph (CORB-SLAM, sections 2.1 and 2.3; docs/wire.md).
#ifndef CORBSLAM_SLAM_EXCHANGE_MAP_UPDATE_H_
#define CORBSLAM_SLAM_EXCHANGE_MAP_UPDATE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "slam/camera/camera.h"
#include "slam/camera/recorded_camera.h"
#include "slam/geometry/rigid3.h"
#include "slam/map/keyframe.h"
#include "slam/map/map_point.h"
#include "slam/util/ids.h"

namespace corbslam {

// A keyframe with all that it carries. Its observations come as ObservationChange.
struct FullKeyframe {
  std::shared_ptr<const KeyframePayload> payload;
  Rigid3d camera_from_local;
  KeyframeId parent;  // Invalid: the root of its local map.
  // The code that the payload's features were read from; null where they came plain or never
  // travelled.
  std::shared_ptr<const std::string> code = nullptr;
};

// A keyframe's id and what may change of it.
struct LightKeyframe {
  KeyframeId id;
  Rigid3d camera_from_local;
  KeyframeId parent;
};

struct FullMapPoint {
  MapPointId id;
  Eigen::Vector3d position_in_local = Eigen::Vector3d::Zero();
  KeyframeId reference;
  Descriptor descriptor;
  Eigen::Vector3d normal_in_local = Eigen::Vector3d::Zero();
  double min_distance = 0;
  double max_distance = 0;
};

struct LightMapPoint {
  MapPointId id;
  Eigen::Vector3d position_in_local = Eigen::Vector3d::Zero();
};

// The keyframe is one of the sender's local map; the point may be anybody's (an agent tracks
// against what others made).
struct ObservationChange {
  enum class Kind { kAdded, kRemoved };
  Kind kind = Kind::kAdded;
  MapPointId point;
  KeyframeId keyframe;
  uint32_t keypoint = 0;
};

struct PointReplacement {
  MapPointId replaced;  // A point of the sender's local map.
  MapPointId survivor;  // A point of any local map.
};

struct KeyframeRemoval {
  KeyframeId id;
  KeyframeId parent;
  Rigid3d parent_from_removed;
};

// A loop that the agent closed; `b` may be another local map's (a loop closed against shared
// keyframes).
struct LoopEdge {
  KeyframeId a;
  KeyframeId b;
  Similarity3d b_from_a;  // x_in_camera_b = b_from_a * x_in_camera_a.
};

// Where a frame was, relative to a keyframe, so that its pose follows later corrections.
struct TrackedFrame {
  int64_t timestamp_ns = 0;
  KeyframeId reference;
  Rigid3d reference_from_camera;
};

// A batch is applied as a whole, in the order of the fields. Additions come before what refers to
// them.
struct MapUpdateBatch {
  LocalMapId local_map;
  // Batches of a local map are numbered 1, 2, 3, ...
  uint64_t number = 0;
  // First index of `cameras`, which are in the order of KeyframePayload::camera_index; only those
  // not sent before are there.
  uint32_t first_camera_index = 0;
  std::vector<std::shared_ptr<const Camera>> cameras;
  // The cameras that recorded the pictures of `cameras`: as many, or none where nobody said it.
  std::vector<RecordedCamera> recorded_cameras;
  std::vector<FullKeyframe> full_keyframes;
  std::vector<FullMapPoint> full_points;
  std::vector<LightKeyframe> light_keyframes;
  std::vector<LightMapPoint> light_points;
  // A point of the sender moves with its reference keyframe wherever `light_keyframes` says that
  // this moved, before `light_points` say where points are. Else points stay.
  bool points_follow = false;
  std::vector<PointReplacement> replacements;
  std::vector<ObservationChange> observations;
  std::vector<MapPointId> removed_points;
  std::vector<KeyframeRemoval> removed_keyframes;
  std::vector<LoopEdge> loop_edges;
  std::vector<TrackedFrame> tracked_frames;
  // Times at which tracking was lost: the trajectory has gaps there.
  std::vector<int64_t> lost_frames_ns;
  // No more batches will follow for this local map; all keyframes are settled.
  bool closes_local_map = false;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EXCHANGE_MAP_UPDATE_H_
