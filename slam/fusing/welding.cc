#include "slam/fusing/welding.h"

#include <algorithm>
#include <utility>

#include "slam/fusing/duplicate_search.h"
#include "slam/fusing/trial_merges.h"
#include "slam/optimisation/bundle_adjustment.h"
#include "slam/verification/neighbourhood.h"

namespace corbslam {
namespace {

// So many keyframes outside the window hold it, those that see the most of it.
constexpr size_t kMaxOuterKeyframes = 16;
constexpr int kMinSharedWithOuter = 10;

struct Window {
  absl::btree_set<KeyframeId> anchors;
  absl::btree_set<KeyframeId> movers;
  std::vector<KeyframeId> outer;
  // Nobody asks this map who is covisible.
  Map map{Covisibility::kGiven};
};

void InsertNeighbourhood(const Map& map, KeyframeId centre, int count,
                         absl::btree_set<KeyframeId>& ids) {
  for (const Keyframe* keyframe : Neighbourhood(map, centre, count - 1)) {
    ids.insert(keyframe->id());
  }
}

const Keyframe* FindKeyframe(const FusingProblem& problem, KeyframeId id) {
  const Keyframe* keyframe = problem.target->FindKeyframe(id);
  return keyframe != nullptr ? keyframe : problem.source->FindKeyframe(id);
}

const MapPoint* FindPoint(const FusingProblem& problem, MapPointId id) {
  const MapPoint* point = problem.target->FindPoint(id);
  return point != nullptr ? point : problem.source->FindPoint(id);
}

std::vector<const MapPoint*> PointsOfWindow(const FusingProblem& problem, const Window& window) {
  absl::btree_set<MapPointId> ids;
  for (const auto* keyframes : {&window.anchors, &window.movers}) {
    for (const KeyframeId& id : *keyframes) {
      for (const MapPointId& point : FindKeyframe(problem, id)->points) {
        if (point.IsValid()) ids.insert(point);
      }
    }
  }
  std::vector<const MapPoint*> points;
  for (const MapPointId& id : ids) {
    if (const MapPoint* point = FindPoint(problem, id)) points.push_back(point);
  }
  return points;
}

std::vector<KeyframeId> ChooseOuter(const Window& window,
                                    const std::vector<const MapPoint*>& points) {
  std::map<KeyframeId, int> shared;
  for (const MapPoint* point : points) {
    for (const auto& [id, keypoint] : point->observations) {
      if (!window.anchors.contains(id) && !window.movers.contains(id)) ++shared[id];
    }
  }
  std::vector<std::pair<KeyframeId, int>> ranked(shared.begin(), shared.end());
  std::erase_if(ranked, [](const auto& entry) { return entry.second < kMinSharedWithOuter; });
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  if (ranked.size() > kMaxOuterKeyframes) ranked.resize(kMaxOuterKeyframes);
  std::vector<KeyframeId> outer;
  for (const auto& [id, count] : ranked) outer.push_back(id);
  std::sort(outer.begin(), outer.end());
  return outer;
}

void AddKeyframe(const FusingProblem& problem, const SolvedGraph& graph, KeyframeId id, Map& map) {
  const Keyframe& original = *FindKeyframe(problem, id);
  Keyframe keyframe;
  keyframe.payload = original.payload;
  keyframe.camera_from_map = graph.camera_from_target.at(id).ToRigid();
  map.AddKeyframe(std::move(keyframe));
}

// Makes the window a map of its own, in the target's frame.
Window MakeWindow(const FusingProblem& problem, const SolvedGraph& graph,
                  const std::map<MapPointId, Eigen::Vector3d>& positions,
                  const MapFusingOptions& options) {
  Window window;
  for (const size_t index : problem.new_overlaps) {
    const OrientedOverlap& overlap = problem.overlaps[index];
    InsertNeighbourhood(problem.MapOf(overlap.anchor), overlap.anchor, options.welding_window,
                        window.anchors);
    InsertNeighbourhood(problem.MapOf(overlap.mover), overlap.mover, options.welding_window,
                        window.movers);
  }
  for (const KeyframeId& id : window.anchors) window.movers.erase(id);
  const std::vector<const MapPoint*> points = PointsOfWindow(problem, window);
  window.outer = ChooseOuter(window, points);
  for (const KeyframeId& id : window.anchors) AddKeyframe(problem, graph, id, window.map);
  for (const KeyframeId& id : window.movers) AddKeyframe(problem, graph, id, window.map);
  for (const KeyframeId& id : window.outer) AddKeyframe(problem, graph, id, window.map);
  for (const MapPoint* point : points) {
    MapPoint copy = *point;
    if (const auto it = positions.find(point->id); it != positions.end()) {
      copy.position_in_map = it->second;
    }
    window.map.AddPoint(std::move(copy));
    for (const auto& [keyframe, keypoint] : point->observations) {
      window.map.AddObservation(point->id, keyframe, keypoint);
    }
    window.map.UpdatePointGeometry(point->id);
  }
  return window;
}

std::vector<const Keyframe*> Lookup(const Map& map, const absl::btree_set<KeyframeId>& ids) {
  std::vector<const Keyframe*> keyframes;
  for (const KeyframeId& id : ids) keyframes.push_back(map.FindKeyframe(id));
  return keyframes;
}

std::vector<TrialMerge> MergeDuplicates(const FusingProblem& problem, Window& window,
                                        LocalMapId only_moves) {
  std::vector<std::pair<MapPointId, MapPointId>> known;
  for (const size_t index : problem.new_overlaps) {
    const auto& points = problem.overlaps[index].points;
    known.insert(known.end(), points.begin(), points.end());
  }
  DuplicateSearchOptions search;
  search.check_disparity = problem.fix_scale;
  std::vector<TrialMerge> merges;
  for (const auto& [anchor, mover] :
       FindDuplicates(window.map, Lookup(window.map, window.anchors),
                      Lookup(window.map, window.movers), known, search)) {
    // What others made survives on the robot, whichever side it is on.
    const bool swap =
        only_moves.IsValid() && anchor.local_map == only_moves && mover.local_map != only_moves;
    const FuseMapsResult::Merge merge{swap ? mover : anchor, swap ? anchor : mover};
    if (only_moves.IsValid() && merge.member.local_map != only_moves) continue;
    if (auto trial = MergeOnTrial(merge, window.map)) merges.push_back(*std::move(trial));
  }
  return merges;
}

BundleScope MakeScope(const FusingProblem& problem, const SolvedGraph& graph, const Window& window,
                      const MapFusingOptions& options) {
  BundleScope scope;
  scope.fixed_keyframes = window.outer;
  for (const auto& [id, keyframe] : window.map.keyframes()) {
    if (!window.anchors.contains(id) && !window.movers.contains(id)) continue;
    (graph.fixed.contains(id) ? scope.fixed_keyframes : scope.free_keyframes).push_back(id);
  }
  if (scope.fixed_keyframes.empty()) {
    const KeyframeId anchor = problem.overlaps[problem.new_overlaps.front()].anchor;
    std::erase(scope.free_keyframes, anchor);
    scope.fixed_keyframes.push_back(anchor);
  }
  for (const auto& [id, point] : window.map.points()) {
    if (point.observations.size() < 2) continue;
    // All observers count, in the window or not.
    const MapPoint* in_target = problem.target->FindPoint(id);
    const bool is_free = !options.only_moves.IsValid() || in_target == nullptr ||
                         MovesWith(options.only_moves, *in_target);
    (is_free ? scope.free_points : scope.fixed_points).push_back(id);
  }
  return scope;
}

}  // namespace

absl::StatusOr<WeldingResult> Weld(const FusingProblem& problem, const SolvedGraph& graph,
                                   const std::map<MapPointId, Eigen::Vector3d>& positions,
                                   const MapFusingOptions& options,
                                   const ProgressCallback& progress) {
  Window window = MakeWindow(problem, graph, positions, options);
  const std::vector<TrialMerge> merges = MergeDuplicates(problem, window, options.only_moves);
  const BundleScope scope = MakeScope(problem, graph, window, options);
  if (scope.free_keyframes.empty() || scope.free_points.empty()) {
    return JudgeMerges(merges, window.map, {});
  }
  BundleOptions bundle;
  bundle.max_iterations = options.welding_iterations;
  bundle.outlier_rounds = 1;
  bundle.threads = options.threads;
  bool cancelled = false;
  bundle.keep_going = [&](double part) {
    cancelled = progress != nullptr && !progress(0.6 + 0.4 * part);
    return !cancelled;
  };
  const auto adjusted = AdjustBundle(window.map, scope, bundle);
  if (cancelled) return absl::CancelledError("fusing was cancelled while welding");
  if (!adjusted.ok()) return adjusted.status();
  return JudgeMerges(merges, window.map, *adjusted);
}

}  // namespace corbslam
