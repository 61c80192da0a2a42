// What the map store tells an agent of the global layer: what others made and where its own
// keyframes are in the global frame (CORB-SLAM, section 2.3).
#ifndef CORBSLAM_SLAM_EXCHANGE_SHARED_UPDATE_H_
#define CORBSLAM_SLAM_EXCHANGE_SHARED_UPDATE_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slam/exchange/map_update.h"
#include "slam/geometry/rigid3.h"
#include "slam/map/keyframe.h"
#include "slam/util/ids.h"

namespace corbslam {

// Another agent's keyframe, in full.
struct SharedKeyframe {
  std::shared_ptr<const KeyframePayload> payload;
  Similarity3d camera_from_global;
  KeyframeId parent;
  // The landmarks (survivors) that it sees, one entry a keypoint as in Keyframe::points.
  std::vector<MapPointId> points;
};

// Another agent's keyframe that the receiver already holds: moved, or with other observations.
struct SharedKeyframeMove {
  KeyframeId id;
  Similarity3d camera_from_global;
};

struct SharedMapPoint {
  MapPointId id;
  Eigen::Vector3d position_in_global = Eigen::Vector3d::Zero();
  KeyframeId reference;
  Descriptor descriptor;
  Eigen::Vector3d normal_in_global = Eigen::Vector3d::Zero();
  double min_distance = 0;
  double max_distance = 0;
};

struct SharedMapPointMove {
  MapPointId id;
  Eigen::Vector3d position_in_global = Eigen::Vector3d::Zero();
};

// Points that are one landmark; `members` does not list the survivor.
struct Landmark {
  MapPointId survivor;
  std::vector<MapPointId> members;
};

// The global pose of one of the receiver's own keyframes that fusion itself has placed.
struct OwnKeyframePose {
  KeyframeId id;
  Similarity3d camera_from_global;
  // The pose in the receiver's own map from which fusion derived it.
  Rigid3d camera_from_local;
};

// One step of the receiver's view of the global layer. A receiver applies it as a whole.
struct SharedUpdate {
  uint64_t revision = 0;
  // True: the receiver forgets all that was shared before (another island's frame, or a resume that
  // can't go on).
  bool restart = false;
  // True: not everything that moved is told yet, so that places of this update do not fit together;
  // the next update goes on.
  bool more_places = false;
  std::vector<SharedKeyframe> keyframes;
  std::vector<SharedMapPoint> points;
  std::vector<SharedKeyframeMove> moved_keyframes;
  std::vector<SharedMapPointMove> moved_points;
  // Observations that came or went on keyframes held already (foreign ones).
  std::vector<ObservationChange> observations;
  std::vector<Landmark> landmarks;
  std::vector<OwnKeyframePose> own_keyframes;
  std::vector<KeyframeId> removed_keyframes;
  std::vector<MapPointId> removed_points;
  // Where the receiver's local map lies as a whole in the mission's global frame; nullopt: as said
  // last. `own_keyframes` that come later say it better.
  std::optional<Similarity3d> global_from_local;
  // The receiver's local map that `own_keyframes` and `global_from_local` are of; invalid: not
  // said.
  LocalMapId local_map;
  // True: the island is not connected to the mission's global frame; what is called global here is
  // the island's own frame.
  bool apart = false;
  // True: the frame is in metres. False: it is not, or the store doesn't say it.
  bool in_metres = false;

  bool IsEmpty() const {
    return !restart && !global_from_local.has_value() && keyframes.empty() && points.empty() &&
           moved_keyframes.empty() && moved_points.empty() && observations.empty() &&
           landmarks.empty() && own_keyframes.empty() && removed_keyframes.empty() &&
           removed_points.empty();
  }
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EXCHANGE_SHARED_UPDATE_H_
