// Finds where others' items belong in the robot's map.
#ifndef CORBSLAM_CLIENT_AGENT_SHARED_PLACEMENT_PLANNER_H_
#define CORBSLAM_CLIENT_AGENT_SHARED_PLACEMENT_PLANNER_H_

#include <Eigen/Core>
#include <map>
#include <optional>
#include <vector>

#include "absl/container/btree_set.h"
#include "client_agent/shared/pinned_keyframes.h"
#include "client_agent/shared/placing_anchors.h"
#include "client_agent/shared/shared_content.h"
#include "slam/map/map.h"

namespace corbslam::client_agent {

// What is to be written into a map: items that are new to it, that are news from the store, or that
// lie elsewhere now. A plan is good as long as the map and the content that it was made of do not
// change.
struct PlacementPlan {
  struct PlacedKeyframe {
    KeyframeId id;
    const ForeignKeyframe* shared;
    Rigid3d camera_from_local;
  };
  struct PlacedPoint {
    const SharedMapPoint* shared;
    Eigen::Vector3d position_in_local;
    Eigen::Vector3d normal_in_local;
  };
  std::vector<PlacedKeyframe> keyframes;
  std::vector<PlacedPoint> points;
};

// Plans the placing of foreign items in one local map. Not thread-safe.
class PlacementPlanner {
 public:
  explicit PlacementPlanner(LocalMapId own) : own_(own), pinned_(own) {}

  // Makes a plan for content with own keyframes that fusion has placed. A foreign keyframe that the
  // robot's own sight pins stays; every other one is placed by the nearest anchor: an own keyframe
  // that fusion has placed, or a foreign one that stays. Points go with the keyframe that they
  // refer to. The plan is to be carried out. Where fusion has placed no own keyframe,
  // `local_from_global` says where all of the robot's frame lies.
  PlacementPlan Plan(const Map& map, const SharedContent& content,
                     const std::optional<Rigid3d>& local_from_global = std::nullopt);

  // Returns local_from_global of each foreign keyframe that was planned.
  const std::map<KeyframeId, Rigid3d>& placings() const { return placings_; }
  // Returns which of others' keyframes own ones pinned when the last plan was made.
  const PinnedKeyframes& pinned() const { return pinned_; }
  // Notes that the keyframe went along with own ones.
  void Move(KeyframeId id, const Rigid3d& after_from_before);
  void Forget(KeyframeId id) { placings_.erase(id); }

 private:
  PlacingAnchors ChooseAnchors(const Map& map, const SharedContent& content,
                               const std::optional<Rigid3d>& local_from_global) const;
  Rigid3d LocalFromGlobal(KeyframeId id, const ForeignKeyframe& shared, const Map& map) const;
  // Returns the keyframes that lie elsewhere now.
  std::vector<KeyframeId> PlanKeyframes(const Map& map, const SharedContent& content,
                                        PlacementPlan& plan);
  void PlanPoints(const std::vector<KeyframeId>& moved, const Map& map,
                  const SharedContent& content, PlacementPlan& plan);
  void PlanPoint(const SharedMapPoint& shared, const Map& map, const SharedContent& content,
                 PlacementPlan& plan);
  // Returns local_from_global at the point; notes whether a keyframe says it.
  Rigid3d PlacingOf(const SharedMapPoint& point, const SharedContent& content);

  const LocalMapId own_;
  PinnedKeyframes pinned_;
  PlacingAnchors anchors_;
  std::map<KeyframeId, Rigid3d> placings_;
  // Foreign points that no foreign keyframe places.
  absl::btree_set<MapPointId> points_alone_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SHARED_PLACEMENT_PLANNER_H_
