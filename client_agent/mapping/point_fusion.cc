#include "client_agent/mapping/point_fusion.h"

#include <algorithm>
#include <vector>

#include "absl/container/flat_hash_set.h"

namespace corbslam::client_agent {
namespace {

constexpr int kNeighbours = 10;
constexpr int kNeighboursWithoutDepth = 20;
constexpr int kSecondNeighbours = 5;

std::vector<KeyframeId> Targets(const Map& map, KeyframeId centre) {
  std::vector<KeyframeId> targets;
  absl::flat_hash_set<KeyframeId> known = {centre};
  const auto add = [&](KeyframeId id) {
    if (known.insert(id).second) targets.push_back(id);
  };
  const Keyframe* const keyframe = map.FindKeyframe(centre);
  const bool has_depths = keyframe == nullptr || keyframe->camera().IsMetric();
  const std::vector<CovisibleKeyframe> first =
      map.BestCovisible(centre, has_depths ? kNeighbours : kNeighboursWithoutDepth);
  for (const CovisibleKeyframe& neighbour : first) {
    add(neighbour.id);
    for (const CovisibleKeyframe& second : map.BestCovisible(neighbour.id, kSecondNeighbours)) {
      add(second.id);
    }
  }
  return targets;
}

void AppendPoints(const Keyframe& keyframe, absl::flat_hash_set<MapPointId>& known,
                  std::vector<MapPointId>& points) {
  for (const MapPointId id : keyframe.points) {
    if (id.IsValid() && known.insert(id).second) points.push_back(id);
  }
}

std::vector<FuseProposal> Propose(const Map& map, KeyframeId keyframe,
                                  const std::vector<MapPointId>& points) {
  const Keyframe* target = map.FindKeyframe(keyframe);
  return target == nullptr ? std::vector<FuseProposal>() : FindFusable(map, *target, points);
}

void FuseInto(KeyframeId target, const std::vector<MapPointId>& points, GuardedMap& guarded) {
  const std::vector<FuseProposal> proposals =
      guarded.Read([&](const Map& map) { return Propose(map, target, points); });
  guarded.Write([&](Map& map) { ApplyFuseProposals(target, proposals, guarded.local_map(), map); });
}

bool ShouldSurvive(const MapPoint& a, const MapPoint& b, LocalMapId own) {
  if (a.id.local_map != own) return true;
  if (b.id.local_map != own) return false;
  return a.observations.size() > b.observations.size();
}

}  // namespace

void ApplyFuseProposals(KeyframeId keyframe_id, absl::Span<const FuseProposal> proposals,
                        LocalMapId own, Map& map) {
  for (const FuseProposal& proposal : proposals) {
    const Keyframe* keyframe = map.FindKeyframe(keyframe_id);
    const MapPoint* point = map.FindPoint(proposal.point);
    if (keyframe == nullptr || point == nullptr) continue;
    if (point->observations.contains(keyframe_id)) continue;
    const MapPoint* existing = map.FindPoint(keyframe->points[proposal.keypoint]);
    if (existing == nullptr) {
      map.AddObservation(proposal.point, keyframe_id, proposal.keypoint);
      continue;
    }
    // Two points of other robots are theirs to join.
    if (existing->id.local_map != own && point->id.local_map != own) continue;
    const MapPointId existing_id = existing->id;
    if (ShouldSurvive(*existing, *point, own)) {
      map.ReplacePoint(proposal.point, existing_id);
    } else {
      map.ReplacePoint(existing_id, proposal.point);
    }
  }
}

void FuseNeighbours(KeyframeId keyframe, GuardedMap& guarded) {
  const std::vector<KeyframeId> targets =
      guarded.Read([&](const Map& map) { return Targets(map, keyframe); });
  std::vector<MapPointId> mine = guarded.Read([&](const Map& map) {
    std::vector<MapPointId> points;
    absl::flat_hash_set<MapPointId> known;
    AppendPoints(*map.FindKeyframe(keyframe), known, points);
    return points;
  });
  for (const KeyframeId target : targets) {
    if (guarded.IsOwn(target)) FuseInto(target, mine, guarded);
  }
  const std::vector<MapPointId> theirs = guarded.Read([&](const Map& map) {
    std::vector<MapPointId> points;
    absl::flat_hash_set<MapPointId> known;
    for (const KeyframeId target : targets) AppendPoints(*map.FindKeyframe(target), known, points);
    return points;
  });
  FuseInto(keyframe, theirs, guarded);
  guarded.Write([&](Map& map) {
    for (const MapPointId id : map.FindKeyframe(keyframe)->points) {
      if (guarded.IsOwn(id)) map.UpdatePointAppearance(id);
    }
  });
}

}  // namespace corbslam::client_agent
