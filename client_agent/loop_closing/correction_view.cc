#include "client_agent/loop_closing/correction_view.h"

#include <vector>

#include "absl/container/btree_set.h"
#include "slam/fusing/map_fusing.h"

namespace corbslam::client_agent {
namespace {

absl::btree_set<KeyframeId> LoopEnds(const Map& map, LocalMapId own,
                                     const std::optional<KeyframeId>& candidate) {
  absl::btree_set<KeyframeId> ends;
  if (candidate.has_value() && candidate->local_map != own) ends.insert(*candidate);
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (id.local_map != own) continue;
    for (const KeyframeId& end : keyframe.loop_edges) {
      if (end.local_map != own) ends.insert(end);
    }
  }
  return ends;
}

absl::btree_set<KeyframeId> OthersAround(const Map& map, LocalMapId own,
                                         const absl::btree_set<KeyframeId>& ends) {
  const int neighbours = MapFusingOptions().welding_window;
  absl::btree_set<KeyframeId> others;
  for (const KeyframeId& end : ends) {
    if (map.FindKeyframe(end) == nullptr) continue;
    others.insert(end);
    for (const CovisibleKeyframe& near : map.BestCovisible(end, neighbours)) {
      if (near.id.local_map != own) others.insert(near.id);
    }
  }
  return others;
}

// A point that others' keyframes hold no more goes with the own ones.
void ReferToOwn(LocalMapId own, Map& view) {
  std::vector<MapPointId> points;
  for (const auto& [id, point] : view.points()) {
    if (id.local_map != own && MovesWith(own, point)) points.push_back(id);
  }
  for (const MapPointId& id : points) {
    const MapPoint point = *view.FindPoint(id);
    view.SetPointAppearance(id, point.descriptor, point.normal_in_map, point.min_distance,
                            point.max_distance, point.observations.begin()->first);
  }
}

}  // namespace

Map CorrectionView(const Map& map, LocalMapId own, const std::optional<KeyframeId>& candidate) {
  const absl::btree_set<KeyframeId> others = OthersAround(map, own, LoopEnds(map, own, candidate));
  std::vector<KeyframeId> keyframes(others.begin(), others.end());
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (id.local_map == own) keyframes.push_back(id);
  }
  absl::btree_set<MapPointId> points;
  for (const KeyframeId& id : keyframes) {
    for (const MapPointId& point : map.FindKeyframe(id)->points) {
      if (point.IsValid()) points.insert(point);
    }
  }
  Map view = map.CopyPart(keyframes, {points.begin(), points.end()});
  ReferToOwn(own, view);
  return view;
}

}  // namespace corbslam::client_agent
