// Remembers where the map store believes a local map's keyframes and points to be, so that only
// what it would get wrong travels.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_BELIEVED_PLACES_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_BELIEVED_PLACES_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "slam/exchange/point_followers.h"
#include "slam/geometry/rigid3.h"
#include "slam/map/map.h"
#include "slam/util/ids.h"

namespace corbslam::client_agent {

// The believed places of one local map. At the store a point keeps its place in the camera of its
// reference, the keyframe that it came with, and so moves when the reference does
// (MapUpdateBatch::points_follow). Positions are in the local map's frame. Not thread-safe.
class BelievedPlaces {
 public:
  // Notes that a keyframe was told, for the first time or anew; its points move with it, unless the
  // store leaves them where they are.
  void PlaceKeyframe(KeyframeId id, const Rigid3d& camera_from_local, bool points_follow = true);
  // The points that followed the keyframe stay where they are.
  void RemoveKeyframe(KeyframeId id) { followers_.Forget(id); }
  // The keyframe `reference` must have been told before.
  void AddPoint(MapPointId id, const Eigen::Vector3d& position_in_local, KeyframeId reference);
  void MovePoint(MapPointId id, const Eigen::Vector3d& position_in_local);
  void RemovePoint(MapPointId id) { points_.erase(id); }
  // Forgets where the store has the points, because that isn't known any more.
  void ForgetPlaces();

  // Returns nullopt where the point was never told, or its place was forgotten.
  std::optional<Eigen::Vector3d> Position(MapPointId id) const;
  // Returns the told points that move with the keyframe.
  const std::vector<MapPointId>& Followers(KeyframeId reference);

 private:
  struct ToldPoint {
    KeyframeId reference;
    std::optional<Eigen::Vector3d> position_in_reference;
  };

  // Poses of told keyframes, of removed ones, too.
  absl::flat_hash_map<KeyframeId, Rigid3d> camera_from_local_;
  absl::flat_hash_map<MapPointId, ToldPoint> points_;
  PointFollowers followers_;
};

// Returns whether taking `told` for the point's position changes where the keyframes of `map` see
// it by `bound_px` pixels at most, in both pictures of a stereo camera; always true where none sees
// it. A place behind a camera that sees the point is too far off.
bool LooksTheSame(const Map& map, const MapPoint& point, const Eigen::Vector3d& told,
                  double bound_px);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_BELIEVED_PLACES_H_
