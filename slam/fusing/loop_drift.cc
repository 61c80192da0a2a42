#include "slam/fusing/loop_drift.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <queue>
#include <set>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "slam/optimisation/pose_graph.h"

namespace corbslam {
namespace {

// Half the scene's depth is no drift whatever the way: keyframes may be next to each other.
constexpr double kFreeShareOfDepth = 0.5;
// Monocular odometry drifts in scale too.
constexpr double kFreeScaleFactor = 3;

// Returns the most by which the loop moves its keyframe, or a point straight before it.
double Motion(const Map& map, const OrientedOverlap& loop, double depth) {
  const Similarity3d motion = AlignByOverlap(map, map, loop);
  const Rigid3d map_from_camera = map.FindKeyframe(loop.mover)->camera_from_map.Inverse();
  double moved = 0;
  for (const double z : {0.0, depth}) {
    const Eigen::Vector3d position = map_from_camera * Eigen::Vector3d(0, 0, z);
    moved = std::max(moved, (motion * position - position).norm());
  }
  return moved;
}

// Returns whether the overlap agrees with where the keyframes are.
bool Agrees(const Map& map, const OrientedOverlap& overlap) {
  const double depth = MedianDepth(map, overlap);
  return Motion(map, overlap, depth) <= kFreeShareOfDepth * depth;
}

// Knows the keyframes of a map and how far it is from each to its neighbours.
class Ways {
 public:
  Ways(const FusingProblem& problem, const Map& map) : map_(map) {
    for (const PoseGraphEdge& edge : EssentialGraphEdges(map)) {
      if (edge.a.local_map == edge.b.local_map) Add(edge.a, edge.b);
    }
    if (!problem.HasOneNewOverlap()) return;
    for (size_t i = 0; i < problem.overlaps.size(); ++i) {
      const OrientedOverlap& overlap = problem.overlaps[i];
      if (i == problem.new_overlaps[0] || problem.IsCrossing(overlap)) continue;
      if (&problem.MapOf(overlap.anchor) != &map || !Agrees(map, overlap)) continue;
      Add(overlap.anchor, overlap.mover);
    }
  }

  // Returns the length of the shortest way (Dijkstra), or nothing where there is no way.
  std::optional<double> Length(KeyframeId from, KeyframeId to) const {
    using Reached = std::pair<double, KeyframeId>;
    std::priority_queue<Reached, std::vector<Reached>, std::greater<>> open;
    std::set<KeyframeId> done;
    open.emplace(0, from);
    while (!open.empty()) {
      const auto [length, at] = open.top();
      open.pop();
      if (at == to) return length;
      if (!done.insert(at).second) continue;
      const auto neighbours = neighbours_.find(at);
      if (neighbours == neighbours_.end()) continue;
      for (const auto& [next, step] : neighbours->second) {
        if (!done.contains(next)) open.emplace(length + step, next);
      }
    }
    return std::nullopt;
  }

 private:
  Eigen::Vector3d CentreOf(KeyframeId id) const {
    return CameraCentre(map_.FindKeyframe(id)->camera_from_map);
  }
  void Add(KeyframeId a, KeyframeId b) {
    const double length = (CentreOf(a) - CentreOf(b)).norm();
    neighbours_[a].emplace_back(b, length);
    neighbours_[b].emplace_back(a, length);
  }

  const Map& map_;
  absl::flat_hash_map<KeyframeId, std::vector<std::pair<KeyframeId, double>>> neighbours_;
};

}  // namespace

double DriftOfLoop(const FusingProblem& problem, const OrientedOverlap& loop,
                   const MapFusingOptions& options) {
  if (problem.IsCrossing(loop)) return 0;
  if (!problem.HasOneNewOverlap() && loop.anchor.local_map != loop.mover.local_map) return 0;
  const Map& map = problem.MapOf(loop.anchor);
  const auto way = Ways(problem, map).Length(loop.anchor, loop.mover);
  if (!way.has_value()) return 0;
  const double depth = MedianDepth(map, loop);
  const double share = options.max_drift * (problem.fix_scale ? 1 : kFreeScaleFactor);
  return Motion(map, loop, depth) / (share * *way + kFreeShareOfDepth * depth);
}

}  // namespace corbslam
