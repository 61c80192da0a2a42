#include "client_agent/tracking/local_map_view.h"

#include <algorithm>
#include <tuple>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "client_agent/tracking/point_set.h"

namespace corbslam::client_agent {
namespace {

constexpr size_t kMaxKeyframes = 80;
constexpr int kNeighbours = 10;

struct Vote {
  KeyframeId id;
  int points = 0;
};

// Counts votes, and sorts them by points, most first.
std::vector<Vote> CountVotes(const Map& map, const std::vector<MapPointId>& seen) {
  absl::flat_hash_map<KeyframeId, int> points_of;
  for (const MapPointId id : seen) {
    const MapPoint* point = map.FindPoint(id);
    if (point == nullptr) continue;
    for (const auto& [keyframe, keypoint] : point->observations) ++points_of[keyframe];
  }
  std::vector<Vote> votes;
  for (const auto& [id, points] : points_of) votes.push_back({id, points});
  std::sort(votes.begin(), votes.end(), [](const Vote& a, const Vote& b) {
    return std::tuple(-a.points, a.id) < std::tuple(-b.points, b.id);
  });
  return votes;
}

// A set of keyframes in the order in which they came.
class KeyframeList {
 public:
  explicit KeyframeList(const Map& map) : map_(map) {}

  bool Add(KeyframeId id) {
    if (ids_.size() >= kMaxKeyframes || map_.FindKeyframe(id) == nullptr) return false;
    if (!known_.insert(id).second) return false;
    ids_.push_back(id);
    return true;
  }
  const std::vector<KeyframeId>& ids() const { return ids_; }

 private:
  const Map& map_;
  std::vector<KeyframeId> ids_;
  absl::flat_hash_set<KeyframeId> known_;
};

void AddNeighbours(const Map& map, KeyframeList& list) {
  const std::vector<KeyframeId> seeds = list.ids();
  for (const KeyframeId id : seeds) {
    for (const CovisibleKeyframe& neighbour : map.BestCovisible(id, kNeighbours)) {
      if (list.Add(neighbour.id)) break;
    }
    const Keyframe& keyframe = *map.FindKeyframe(id);
    for (const KeyframeId child : keyframe.children) {
      if (list.Add(child)) break;
    }
    list.Add(keyframe.parent);
  }
}

// An observation with depth counts twice.
bool IsSeenBy(const Map& map, const MapPoint& point, int enough) {
  int count = 0;
  for (const auto& [id, keypoint] : point.observations) {
    count += map.FindKeyframe(id)->keypoints()[keypoint].HasDepth() ? 2 : 1;
    if (count >= enough) return true;
  }
  return false;
}

int CountReferencePoints(const Map& map, const Keyframe& reference) {
  const int enough = map.keyframes().size() <= 2 ? 2 : 3;
  int count = 0;
  for (const MapPointId id : reference.points) {
    if (const MapPoint* point = map.FindPoint(id)) count += IsSeenBy(map, *point, enough);
  }
  return count;
}

// Most of thousands of points are out of view, so only those in view are copied.
std::vector<PointInView> CollectPoints(const Map& map, LocalMapId own,
                                       const std::vector<KeyframeId>& keyframes,
                                       const Camera& camera, const Rigid3d& camera_from_map) {
  std::vector<PointInView> points;
  PointSet known(own);
  for (const KeyframeId keyframe : keyframes) {
    for (const MapPointId id : map.FindKeyframe(keyframe)->points) {
      if (!id.IsValid() || !known.Insert(id)) continue;
      const MapPoint& point = *map.FindPoint(id);
      const auto view = PredictView(point, camera, camera_from_map);
      if (view.has_value()) points.push_back({MakeMatchPoint(point), *view});
    }
  }
  return points;
}

}  // namespace

LocalMapView GatherLocalMap(const Map& map, LocalMapId own, const std::vector<MapPointId>& seen,
                            KeyframeId fallback, const Camera& camera,
                            const Rigid3d& camera_from_map) {
  LocalMapView view;
  view.map_keyframes = static_cast<int>(map.keyframes().size());
  KeyframeList list(map);
  for (const Vote& vote : CountVotes(map, seen)) {
    list.Add(vote.id);
    if (view.reference.IsValid() || vote.id.local_map != own) continue;
    view.reference = vote.id;
    view.share_of_reference = static_cast<double>(vote.points) / static_cast<double>(seen.size());
  }
  if (list.ids().empty()) list.Add(fallback);
  if (!view.reference.IsValid() && map.FindKeyframe(fallback) != nullptr) view.reference = fallback;
  AddNeighbours(map, list);
  view.points = CollectPoints(map, own, list.ids(), camera, camera_from_map);
  if (const Keyframe* reference = map.FindKeyframe(view.reference)) {
    view.reference_from_map = reference->camera_from_map;
    view.reference_points = CountReferencePoints(map, *reference);
  }
  return view;
}

void ReferToOthers(const Map& map, const std::vector<MapPointId>& seen, LocalMapView& view) {
  const std::vector<Vote> votes = CountVotes(map, seen);
  if (votes.empty()) return;
  const Keyframe& reference = *map.FindKeyframe(votes.front().id);
  view.reference = votes.front().id;
  view.share_of_reference =
      static_cast<double>(votes.front().points) / static_cast<double>(seen.size());
  view.reference_from_map = reference.camera_from_map;
  view.reference_points = CountReferencePoints(map, reference);
}

}  // namespace corbslam::client_agent
