#include "slam/fusing/map_fusing.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "absl/strings/str_cat.h"
#include "slam/fusing/fusing_graph.h"
#include "slam/fusing/loop_drift.h"
#include "slam/fusing/map_alignment.h"
#include "slam/fusing/welding.h"
#include "slam/optimisation/pose_graph.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

constexpr double kMoved = 1e-9;

absl::Status CheckOverlap(const FuseMapsRequest& request, const Overlap& overlap) {
  const auto is_known = [&](KeyframeId id) {
    return request.target.FindKeyframe(id) != nullptr || request.source.FindKeyframe(id) != nullptr;
  };
  for (const KeyframeId& id : {overlap.query, overlap.candidate}) {
    if (!is_known(id)) {
      return absl::InvalidArgumentError(
          absl::StrCat("overlap names keyframe ", ToString(id), ", which is in neither view"));
    }
  }
  if (overlap.query == overlap.candidate) {
    return absl::InvalidArgumentError(
        absl::StrCat("overlap of keyframe ", ToString(overlap.query), " with itself"));
  }
  const Similarity3d& pose = overlap.candidate_from_query;
  const bool is_finite = pose.translation.allFinite() && pose.rotation.coeffs().allFinite() &&
                         std::isfinite(pose.scale) && pose.scale > 0;
  if (!is_finite) {
    return absl::InvalidArgumentError(absl::StrCat("overlap of keyframes ", ToString(overlap.query),
                                                   " and ", ToString(overlap.candidate),
                                                   " has a similarity that is not finite"));
  }
  if (!IsCovariance(overlap.covariance)) {
    return absl::InvalidArgumentError(absl::StrCat("overlap of keyframes ", ToString(overlap.query),
                                                   " and ", ToString(overlap.candidate),
                                                   " has a covariance that is none"));
  }
  return absl::OkStatus();
}

absl::Status CheckRequest(const FuseMapsRequest& request) {
  if (request.new_overlaps.empty()) {
    return absl::InvalidArgumentError("no new overlap to fuse by");
  }
  for (const size_t index : request.new_overlaps) {
    if (index < request.overlaps.size()) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("new overlap ", index, " of only ", request.overlaps.size(), " overlaps"));
  }
  for (const Overlap& overlap : request.overlaps) RETURN_IF_ERROR(CheckOverlap(request, overlap));
  for (const auto& [id, keyframe] : request.source.keyframes()) {
    if (request.target.FindKeyframe(id) == nullptr) continue;
    return absl::InvalidArgumentError(absl::StrCat("keyframe ", ToString(id), " is in both views"));
  }
  for (const auto& [id, point] : request.source.points()) {
    if (request.target.FindPoint(id) == nullptr) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("map point ", ToString(id), " is in both views"));
  }
  return absl::OkStatus();
}

// The anchor is the keyframe that may not move (on a robot) or the one in the target (in fusion).
bool AnchorIsQuery(const FuseMapsRequest& request, const Overlap& overlap, LocalMapId only_moves) {
  const bool query_stays = request.target.FindKeyframe(overlap.query) != nullptr;
  const bool candidate_stays = request.target.FindKeyframe(overlap.candidate) != nullptr;
  if (query_stays != candidate_stays) return query_stays;
  return only_moves.IsValid() && overlap.candidate.local_map == only_moves &&
         overlap.query.local_map != only_moves;
}

std::vector<KeyframeId> KeyframesInMetres(const Map& map) {
  std::vector<KeyframeId> ids;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (keyframe.camera().IsMetric()) ids.push_back(id);
  }
  return ids;
}

// Sets which keyframes keep their scale, and says whether both maps are in metres. A source alone
// in metres gives the target none: the target's frame stays.
bool HoldMetres(FusingProblem& problem) {
  const std::vector<KeyframeId> of_target = KeyframesInMetres(*problem.target);
  if (of_target.empty()) return false;
  const std::vector<KeyframeId> of_source = KeyframesInMetres(*problem.source);
  problem.in_metres.insert(of_target.begin(), of_target.end());
  problem.in_metres.insert(of_source.begin(), of_source.end());
  return !of_source.empty();
}

FusingProblem MakeProblem(const FuseMapsRequest& request, const MapFusingOptions& options) {
  FusingProblem problem;
  problem.target = &request.target;
  problem.source = &request.source;
  problem.new_overlaps = request.new_overlaps;
  problem.fix_scale = request.fix_scale;
  for (const Overlap& overlap : request.overlaps) {
    problem.overlaps.push_back(
        Orient(overlap, AnchorIsQuery(request, overlap, options.only_moves)));
    if (problem.fix_scale) problem.overlaps.back().anchor_from_mover.scale = 1;
  }
  return problem;
}

// Sets how the source first comes into the target's frame, as large as it is where both are in
// metres.
absl::Status PlaceSource(FusingProblem& problem) {
  const bool both_in_metres = !problem.fix_scale && HoldMetres(problem);
  if (problem.source->keyframes().empty()) return absl::OkStatus();
  std::vector<OrientedOverlap> crossing;
  for (const OrientedOverlap& overlap : problem.overlaps) {
    if (!problem.IsCrossing(overlap)) continue;
    crossing.push_back(overlap);
    if (both_in_metres) crossing.back().anchor_from_mover.scale = 1;
  }
  const auto alignment = AlignByConsensus(*problem.target, *problem.source, crossing);
  if (!alignment.has_value()) {
    return absl::InvalidArgumentError("no overlap joins the source to the target");
  }
  problem.target_from_source = *alignment;
  return absl::OkStatus();
}

// Moves all points of the source, and those of the target that the graph moved, in the target's
// frame.
std::map<MapPointId, Eigen::Vector3d> MovePoints(const FusingProblem& problem,
                                                 const SolvedGraph& graph) {
  std::map<MapPointId, Eigen::Vector3d> positions;
  for (const PositionUpdate& update :
       MovePointsWithReferences(*problem.target, graph.camera_from_target)) {
    positions[update.id] = update.position_in_map;
  }
  for (const auto& [id, point] : problem.source->points()) {
    positions[id] = problem.target_from_source * point.position_in_map;
  }
  for (const PositionUpdate& update :
       MovePointsWithReferences(*problem.source, graph.camera_from_target)) {
    positions[update.id] = update.position_in_map;
  }
  return positions;
}

void KeepPointsOfOthers(const Map& map, LocalMapId only_moves,
                        std::map<MapPointId, Eigen::Vector3d>& positions) {
  if (!only_moves.IsValid()) return;
  for (const auto& [id, point] : map.points()) {
    if (!MovesWith(only_moves, point)) positions.erase(id);
  }
}

// Applies the rule of MapFusingOptions::max_edge_chi2.
bool ContradictsGraph(const FusingProblem& problem, const SolvedGraph& graph, double max_chi2) {
  const std::set<size_t> new_overlaps(problem.new_overlaps.begin(), problem.new_overlaps.end());
  const bool is_bounded = std::isfinite(max_chi2);
  size_t overturned = 0;
  for (size_t i = 0; i < problem.overlaps.size(); ++i) {
    const bool disagrees = graph.chi2[i] > max_chi2;
    if (new_overlaps.contains(i) && (disagrees || (is_bounded && graph.outvoted[i]))) return true;
    if (!disagrees) continue;
    overturned += graph.initial_chi2[i] <= max_chi2;
  }
  return overturned > 0 && overturned >= new_overlaps.size();
}

bool HasMoved(const Rigid3d& before, const Rigid3d& after) {
  return (CameraCentre(before) - CameraCentre(after)).norm() > kMoved ||
         RotationAngle(before.rotation.conjugate() * after.rotation) > kMoved;
}

void CollectPoses(const FusingProblem& problem, const SolvedGraph& graph,
                  const WeldingResult& welding, FuseMapsResult& result) {
  for (const auto& [id, camera_from_target] : graph.camera_from_target) {
    Similarity3d pose = camera_from_target;
    if (const auto it = welding.poses.find(id); it != welding.poses.end()) {
      pose.rotation = it->second.rotation;
      pose.translation = pose.scale * it->second.translation;
    }
    const Keyframe* before = problem.target->FindKeyframe(id);
    if (before != nullptr && !HasMoved(before->camera_from_map, pose.ToRigid())) continue;
    result.poses.push_back({id, pose});
  }
}

void CollectPositions(const FusingProblem& problem, std::map<MapPointId, Eigen::Vector3d> positions,
                      const WeldingResult& welding, FuseMapsResult& result) {
  for (const auto& [id, position] : welding.positions) positions[id] = position;
  for (const FuseMapsResult::Merge& merge : welding.merges) positions.erase(merge.member);
  for (const auto& [id, position] : positions) {
    const MapPoint* before = problem.target->FindPoint(id);
    if (before != nullptr && (before->position_in_map - position).norm() <= kMoved) continue;
    result.positions.push_back({id, position});
  }
}

}  // namespace

absl::btree_set<KeyframeId> KeyframesThatStay(const Map& map, LocalMapId only_moves) {
  absl::btree_set<KeyframeId> stay;
  bool has_root = false;
  for (const auto& [id, keyframe] : map.keyframes()) {
    const bool is_own = !only_moves.IsValid() || id.local_map == only_moves;
    const bool is_root = is_own && !has_root && !keyframe.parent.IsValid();
    if (is_root) has_root = true;
    if (!is_own || is_root) stay.insert(id);
  }
  return stay;
}

bool MovesWith(LocalMapId local_map, const MapPoint& point) {
  return point.id.local_map == local_map ||
         std::ranges::all_of(point.observations, [local_map](const auto& observation) {
           return observation.first.local_map == local_map;
         });
}

absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest& request,
                                        const MapFusingOptions& options,
                                        const ProgressCallback& progress) {
  RETURN_IF_ERROR(CheckRequest(request));
  const auto is_cancelled = [&](double part) { return progress != nullptr && !progress(part); };
  if (is_cancelled(0)) return absl::CancelledError("fusing was cancelled before it began");
  FusingProblem problem = MakeProblem(request, options);
  RETURN_IF_ERROR(PlaceSource(problem));

  FuseMapsResult result;
  result.base_revision = request.base_revision;
  for (const size_t index : problem.new_overlaps) {
    if (DriftOfLoop(problem, problem.overlaps[index], options) > 1) return result;
  }
  ASSIGN_OR_RETURN(const SolvedGraph graph, SolveFusingGraph(problem, options));
  result.worst_edge_chi2 = *std::max_element(graph.chi2.begin(), graph.chi2.end());
  if (ContradictsGraph(problem, graph, options.max_edge_chi2)) return result;
  if (is_cancelled(0.5)) return absl::CancelledError("fusing was cancelled after the graph");

  std::map<MapPointId, Eigen::Vector3d> positions = MovePoints(problem, graph);
  KeepPointsOfOthers(request.target, options.only_moves, positions);
  ASSIGN_OR_RETURN(WeldingResult welding, Weld(problem, graph, positions, options, progress));

  result.accepted = true;
  result.target_from_source = problem.target_from_source;
  CollectPoses(problem, graph, welding, result);
  CollectPositions(problem, std::move(positions), welding, result);
  result.merges = std::move(welding.merges);
  result.rejected = std::move(welding.rejected);
  return result;
}

}  // namespace corbslam
