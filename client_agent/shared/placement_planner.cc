#include "client_agent/shared/placement_planner.h"

namespace corbslam::client_agent {
namespace {

// A keyframe whose placing differs by less is left where it is, because the difference is below
// what tracking can see.
constexpr double kSmallestMotion_m = 1e-4;
constexpr double kSmallestTurn_rad = 1e-5;

bool HasMoved(const Rigid3d& before, const Rigid3d& now) {
  const Rigid3d motion = now * before.Inverse();
  return motion.translation.norm() > kSmallestMotion_m ||
         RotationAngle(motion.rotation) > kSmallestTurn_rad;
}

bool IsNews(KeyframeId id, const SharedContent& content) {
  const auto news = content.news().find(id.local_map);
  return news != content.news().end() && news->second.keyframes.contains(id);
}

}  // namespace

void PlacementPlanner::Move(KeyframeId id, const Rigid3d& after_from_before) {
  const auto it = placings_.find(id);
  if (it != placings_.end()) it->second = after_from_before * it->second;
}

PlacementPlan PlacementPlanner::Plan(const Map& map, const SharedContent& content,
                                     const std::optional<Rigid3d>& local_from_global) {
  PlacementPlan plan;
  pinned_.Update(map);
  anchors_ = ChooseAnchors(map, content, local_from_global);
  PlanPoints(PlanKeyframes(map, content, plan), map, content, plan);
  return plan;
}

// Foreign keyframes that stay take the place of the own ones that share points with them: fusion
// may have placed the own ones by what it knew before it looked at the points.
PlacingAnchors PlacementPlanner::ChooseAnchors(
    const Map& map, const SharedContent& content,
    const std::optional<Rigid3d>& local_from_global) const {
  PlacingAnchors anchors;
  absl::btree_set<KeyframeId> superseded;
  for (const auto& [id, shared] : content.keyframes()) {
    if (!pinned_.Contains(id)) continue;
    anchors.Add(shared.camera_from_global.ToRigid(), LocalFromGlobal(id, shared, map));
    for (const CovisibleKeyframe& sharing : map.Covisible(id)) {
      if (sharing.id.local_map == own_) superseded.insert(sharing.id);
    }
  }
  for (const auto& [id, place] : content.own_places().places()) {
    if (superseded.contains(id)) continue;
    anchors.Add(place.camera_from_global, place.LocalFromGlobal());
  }
  if (content.own_places().places().empty() && local_from_global.has_value()) {
    anchors.Add(Rigid3d::Identity(), *local_from_global);
  }
  return anchors;
}

Rigid3d PlacementPlanner::LocalFromGlobal(KeyframeId id, const ForeignKeyframe& shared,
                                          const Map& map) const {
  const Rigid3d camera_from_global = shared.camera_from_global.ToRigid();
  if (!pinned_.Contains(id)) return anchors_.LocalFromGlobalAt(CameraCentre(camera_from_global));
  return map.FindKeyframe(id)->camera_from_map.Inverse() * camera_from_global;
}

std::vector<KeyframeId> PlacementPlanner::PlanKeyframes(const Map& map,
                                                        const SharedContent& content,
                                                        PlacementPlan& plan) {
  std::vector<KeyframeId> moved;
  for (const auto& [id, shared] : content.keyframes()) {
    const Rigid3d local_from_global = LocalFromGlobal(id, shared, map);
    const auto [placing, is_new] = placings_.try_emplace(id, local_from_global);
    const bool has_moved = is_new || HasMoved(placing->second, local_from_global);
    if (has_moved) {
      placing->second = local_from_global;
      moved.push_back(id);
    }
    if (!has_moved && !IsNews(id, content)) continue;
    plan.keyframes.push_back(
        {id, &shared, shared.camera_from_global.ToRigid() * placing->second.Inverse()});
  }
  return moved;
}

void PlacementPlanner::PlanPoints(const std::vector<KeyframeId>& moved, const Map& map,
                                  const SharedContent& content, PlacementPlan& plan) {
  absl::btree_set<MapPointId> due;
  for (const auto& [source, news] : content.news()) {
    due.insert(news.points.begin(), news.points.end());
  }
  absl::erase_if(points_alone_, [&](MapPointId id) { return content.FindPoint(id) == nullptr; });
  due.insert(points_alone_.begin(), points_alone_.end());
  for (const MapPointId id : due) {
    if (const SharedMapPoint* shared = content.FindPoint(id)) {
      PlanPoint(*shared, map, content, plan);
    }
  }
  for (const KeyframeId id : moved) {
    for (const MapPointId& point : content.FindKeyframe(id)->points) {
      const SharedMapPoint* shared = content.FindPoint(point);
      if (shared == nullptr || content.PlacingKeyframeOf(*shared) != id || due.contains(point))
        continue;
      PlanPoint(*shared, map, content, plan);
    }
  }
}

void PlacementPlanner::PlanPoint(const SharedMapPoint& shared, const Map& map,
                                 const SharedContent& content, PlacementPlan& plan) {
  if (content.Representative(map, shared.id) != shared.id) return;
  const Rigid3d local_from_global = PlacingOf(shared, content);
  plan.points.push_back({&shared, local_from_global * shared.position_in_global,
                         local_from_global.rotation * shared.normal_in_global});
}

Rigid3d PlacementPlanner::PlacingOf(const SharedMapPoint& point, const SharedContent& content) {
  const auto placing = placings_.find(content.PlacingKeyframeOf(point));
  if (placing != placings_.end()) {
    points_alone_.erase(point.id);
    return placing->second;
  }
  points_alone_.insert(point.id);
  return anchors_.LocalFromGlobalAt(point.position_in_global);
}

}  // namespace corbslam::client_agent
