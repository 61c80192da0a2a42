// Hears every change of a Map, to record what a map store must be told.
#ifndef CORBSLAM_SLAM_MAP_MAP_OBSERVER_H_
#define CORBSLAM_SLAM_MAP_MAP_OBSERVER_H_

#include <cstdint>

#include "slam/geometry/rigid3.h"
#include "slam/util/ids.h"

namespace corbslam {

// The thread that changes the map calls it synchronously, after the change. It must not change the
// map. Every method does nothing by default.
class MapObserver {
 public:
  virtual ~MapObserver() = default;

  virtual void OnKeyframeAdded(KeyframeId) {}
  virtual void OnKeyframeMoved(KeyframeId) {}
  virtual void OnParentChanged(KeyframeId) {}
  virtual void OnLoopEdgeAdded(KeyframeId, KeyframeId) {}
  // The removed keyframe's children now hang on `parent`.
  virtual void OnKeyframeRemoved(KeyframeId, KeyframeId /*parent*/,
                                 const Rigid3d& /*parent_from_removed*/) {}
  virtual void OnPointAdded(MapPointId) {}
  virtual void OnPointMoved(MapPointId) {}
  virtual void OnObservationAdded(MapPointId, KeyframeId, uint32_t /*keypoint*/) {}
  virtual void OnObservationRemoved(MapPointId, KeyframeId, uint32_t /*keypoint*/) {}
  // All observations of `replaced` have gone over to `survivor` (or were dropped where the
  // keyframe saw both). Single observation calls are not made for them.
  virtual void OnPointReplaced(MapPointId /*replaced*/, MapPointId /*survivor*/) {}
  virtual void OnPointRemoved(MapPointId) {}
  // Asked before a keyframe's keypoints change; returns false where it has been told to others with
  // those that it has.
  virtual bool MayChangeKeypoints(KeyframeId) const { return true; }
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_MAP_MAP_OBSERVER_H_
