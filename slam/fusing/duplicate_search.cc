#include "slam/fusing/duplicate_search.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "absl/container/btree_set.h"
#include "slam/verification/neighbourhood.h"
#include "slam/verification/projection_search.h"

namespace corbslam {
namespace {

using PointIdPair = std::pair<MapPointId, MapPointId>;

struct Votes {
  int count = 0;
  int distance = 257;
};

absl::btree_set<MapPointId> IdsOf(const std::vector<const MapPoint*>& points) {
  absl::btree_set<MapPointId> ids;
  for (const MapPoint* point : points) ids.insert(point->id);
  return ids;
}

// Returns those of `points` that are not among `others`.
std::vector<const MapPoint*> Without(const std::vector<const MapPoint*>& points,
                                     const absl::btree_set<MapPointId>& others) {
  std::vector<const MapPoint*> rest;
  for (const MapPoint* point : points) {
    if (!others.contains(point->id)) rest.push_back(point);
  }
  return rest;
}

void VoteByProjection(const std::vector<const MapPoint*>& points,
                      const std::vector<const Keyframe*>& keyframes,
                      const absl::btree_set<MapPointId>& own_points,
                      const ProjectionSearchOptions& search, bool points_are_anchors,
                      std::map<PointIdPair, Votes>& votes) {
  for (const Keyframe* keyframe : keyframes) {
    for (const ProjectionMatch& match :
         FindByProjection(points, *keyframe, keyframe->camera_from_map, search)) {
      const MapPointId projected = points[match.point]->id;
      const MapPointId seen = keyframe->points[match.keypoint];
      // Both sides see it: it is no duplicate but a link that stands already.
      if (own_points.contains(seen)) continue;
      Votes& vote =
          votes[points_are_anchors ? PointIdPair(projected, seen) : PointIdPair(seen, projected)];
      ++vote.count;
      vote.distance = std::min(vote.distance, match.distance);
    }
  }
}

// Two points that one keyframe sees apart are two.
bool AreSeenApart(const Map& map, const PointIdPair& pair) {
  const MapPoint* a = map.FindPoint(pair.first);
  const MapPoint* b = map.FindPoint(pair.second);
  for (const auto& [keyframe, keypoint] : a->observations) {
    if (b->observations.contains(keyframe)) return true;
  }
  return false;
}

}  // namespace

std::vector<PointIdPair> FindDuplicates(const Map& map, const std::vector<const Keyframe*>& anchors,
                                        const std::vector<const Keyframe*>& movers,
                                        const std::vector<PointIdPair>& known,
                                        const DuplicateSearchOptions& options) {
  const auto all_of_anchors = PointsSeenBy(map, anchors);
  const auto all_of_movers = PointsSeenBy(map, movers);
  const auto anchor_ids = IdsOf(all_of_anchors);
  const auto mover_ids = IdsOf(all_of_movers);
  const ProjectionSearchOptions search{.radius_px = options.radius_px,
                                       .max_distance = options.max_distance,
                                       .only_keypoints_with_points = true,
                                       .check_disparity = options.check_disparity};
  std::map<PointIdPair, Votes> votes;
  VoteByProjection(Without(all_of_anchors, mover_ids), movers, anchor_ids, search, true, votes);
  VoteByProjection(Without(all_of_movers, anchor_ids), anchors, mover_ids, search, false, votes);
  for (const PointIdPair& pair : known) {
    if (pair.first == pair.second) continue;
    if (map.FindPoint(pair.first) == nullptr || map.FindPoint(pair.second) == nullptr) continue;
    votes[pair] = {static_cast<int>(map.keyframes().size()) + 1, 0};
  }
  std::vector<std::pair<PointIdPair, Votes>> ranked(votes.begin(), votes.end());
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) {
    return std::tuple(-a.second.count, a.second.distance) <
           std::tuple(-b.second.count, b.second.distance);
  });
  absl::btree_set<MapPointId> taken;
  std::vector<PointIdPair> pairs;
  for (const auto& [pair, vote] : ranked) {
    if (taken.contains(pair.first) || taken.contains(pair.second)) continue;
    if (AreSeenApart(map, pair)) continue;
    taken.insert(pair.first);
    taken.insert(pair.second);
    pairs.push_back(pair);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace corbslam
