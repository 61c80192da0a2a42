// One image on its way through tracking.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_FRAME_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_FRAME_H_

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "client_agent/map/map_history.h"
#include "slam/geometry/lie.h"
#include "slam/geometry/rigid3.h"
#include "slam/map/keyframe.h"
#include "slam/map/map.h"
#include "slam/optimisation/pose_optimisation.h"
#include "slam/util/ids.h"
#include "slam/vocabulary/words.h"

namespace corbslam::client_agent {

// What a keypoint is taken to see.
struct Association {
  enum class Kind : char {
    kNone,
    kMapPoint,
    // A point made from the depth of one earlier frame, which is in no map ("visual odometry
    // point", ORB-SLAM2), or which mapping has not made yet.
    kTemporary,
  };
  Kind kind = Kind::kNone;
  MapPointId id;  // Id of a map point.
  Eigen::Vector3d position_in_map = Eigen::Vector3d::Zero();
};

// What parallax said of how far away a keypoint is, along the camera's axis, in the map's unit.
struct FoundDepth {
  uint32_t keypoint = 0;
  double depth = 0;
};

struct Frame {
  // Its id is invalid: a frame is no keyframe.
  std::shared_ptr<const KeyframePayload> payload;
  // Words are computed when they are needed.
  std::shared_ptr<const Words> words;
  Rigid3d camera_from_map;
  // The own keyframe whose later motion the frame follows.
  KeyframeId reference;
  Rigid3d camera_from_reference;
  // The keyframe that the frame became, if it did.
  KeyframeId keyframe;
  // The associations have one entry a keypoint.
  std::vector<Association> associations;
  // One camera alone: of the frame that a map begins with, and of those after it until mapping has
  // made its points.
  std::vector<FoundDepth> found_depths;

  const Camera& camera() const { return *payload->camera; }
  const std::vector<Keypoint>& keypoints() const { return payload->features.keypoints; }
  const std::vector<Descriptor>& descriptors() const { return payload->features.descriptors; }
};

// The picture needs no grid yet.
Frame MakeFrame(KeyframePayload picture);

// Brings an earlier frame up to date with the map: its pose follows its reference, its points are
// where they are now, replaced points are their survivors, removed ones are gone. A frame that
// became a keyframe takes the keyframe's points. If the reference is not in the map (yet), the pose
// stays.
void Refresh(const Map& map, const MapHistory& history, Frame& frame);

struct InlierCount {
  int map_points = 0;
  int foreign = 0;  // Number of these points that others than `own` made.
  int temporary = 0;

  int total() const { return map_points + temporary; }
};

// Finds the pose that fits the frame's associations best, from `initial`, and drops those that
// disagree with it.
InlierCount OptimiseFramePose(const Rigid3d& initial_camera_from_map, LocalMapId own, Frame& frame);

// Returns the covariance of the pose that OptimiseFramePose found, in the map's axes (InMapAxes);
// nullopt where the associations don't determine it.
std::optional<Matrix6d> FramePoseCovariance(const Frame& frame);

// Returns the map points that the frame's keypoints see, in their order.
std::vector<MapPointId> SeenPoints(const Frame& frame);

// Returns what the frame's associations observe.
std::vector<PoseObservation> ObservationsOf(const Frame& frame);

// Adds temporary associations for keypoints with depth that see no map point: all close ones, and
// the nearest hundred (ORB-SLAM2, Mur-Artal and Tardos, T-RO 2017); and those of found_depths.
void AddTemporaryPoints(Frame& frame);
void DropTemporaryPoints(Frame& frame);
// Has the depths of temporary associations be found_depths, for the frame after this one.
void KeepFoundDepths(Frame& frame);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_FRAME_H_
