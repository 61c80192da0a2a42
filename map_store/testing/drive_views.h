// Views of several sessions over one place, in which everything stands where it truly is.
#ifndef CORBSLAM_MAP_STORE_TESTING_DRIVE_VIEWS_H_
#define CORBSLAM_MAP_STORE_TESTING_DRIVE_VIEWS_H_

#include <map>
#include <utility>
#include <vector>

#include "map_store/retiring/retiring_view.h"
#include "slam/verification/testing/synthetic_world.h"

namespace corbslam::testing {

// How the sessions' points are one another's.
enum class Joined {
  kNone,    // Fusion has found none of them to be the same.
  kMerged,  // Those of one thing are one landmark, of which each session has a point.
  kShared,  // Later sessions see the points of the first one that has the thing, and have none.
};

// Moves things out of everybody's sight.
inline SyntheticWorld Without(SyntheticWorld world, const std::vector<size_t>& things) {
  for (const size_t thing : things) world.positions_m[thing] = {0, 1e4, 0};
  return world;
}

// Returns a view of whole local maps, which are closed and came in this order. All keyframes are
// candidates, and the poses are the true ones.
inline map_store::RetiringView MakeDriveView(const std::vector<const SyntheticMap*>& sessions,
                                             const SyntheticWorld& world, Joined joined) {
  map_store::RetiringView view;
  view.island = sessions.front()->map.keyframes().begin()->first.local_map;
  std::map<size_t, MapPointId> landmark_of;
  for (const SyntheticMap* session : sessions) {
    const LocalMapId id = session->map.keyframes().begin()->first.local_map;
    view.closed[id] = {id, view.closed.size(), 1, session->map.keyframes().size()};
    for (const auto& [keyframe_id, from] : session->map.keyframes()) {
      const Rigid3d& pose = session->true_camera_from_world.at(keyframe_id);
      Keyframe keyframe;
      keyframe.payload = from.payload;
      keyframe.camera_from_map = pose;
      keyframe.parent = from.parent;
      view.map.AddKeyframe(std::move(keyframe));
      view.poses[keyframe_id] = Similarity3d::FromRigid(pose);
      if (from.parent.IsValid()) view.parents[keyframe_id] = from.parent;
      view.local_poses[keyframe_id] = from.camera_from_map;
      view.candidates.insert(keyframe_id);
    }
    for (const auto& [point_id, from] : session->map.points()) {
      const size_t thing = session->world_point.at(point_id);
      MapPointId landmark = point_id;
      if (joined != Joined::kNone)
        landmark = landmark_of.try_emplace(thing, point_id).first->second;
      MapPoint point = from;
      point.id = landmark;
      point.position_in_map = world.positions_m[thing];
      point.observations.clear();
      view.map.AddPoint(std::move(point));
      const bool has_own = joined != Joined::kShared || landmark == point_id;
      if (has_own) view.landmarks[landmark].push_back(point_id);
      for (const auto& [keyframe, keypoint] : from.observations) {
        view.map.AddObservation(landmark, keyframe, keypoint);
      }
    }
  }
  for (const auto& [landmark, members] : view.landmarks) view.map.UpdatePointAppearance(landmark);
  return view;
}

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_DRIVE_VIEWS_H_
