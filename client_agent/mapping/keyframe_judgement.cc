#include "client_agent/mapping/keyframe_judgement.h"

#include <iterator>

#include "client_agent/map/provisional_keyframes.h"
#include "client_agent/mapping/culling.h"
#include "client_agent/mapping/keyframe_insertion.h"

namespace corbslam {
namespace {

constexpr double kSpannedShare = 0.75;
// As of the points that tracking counts of a reference keyframe.
constexpr int kWellSeen = 3;

bool IsSeenWellWithout(const Map& map, const MapPoint& point, KeyframeId id) {
  int observations = CountObservations(map, point);
  if (const auto own = point.observations.find(id); own != point.observations.end()) {
    observations -= map.FindKeyframe(id)->keypoints()[own->second].HasDepth() ? 2 : 1;
  }
  return observations >= kWellSeen;
}

// Own keyframes beyond `judged` that are not among the newest, in order.
std::vector<KeyframeId> FindUnjudged(const Map& map, LocalMapId own,
                                     const std::optional<uint32_t>& judged) {
  std::vector<KeyframeId> unjudged;
  const KeyframeId last = NewestBut(map, own, kProvisionalKeyframes);
  if (!last.IsValid()) return unjudged;
  const uint32_t first = judged.has_value() ? *judged + 1 : 0;
  for (auto it = map.keyframes().lower_bound({own, first});
       it != map.keyframes().end() && it->first <= last; ++it) {
    unjudged.push_back(it->first);
  }
  return unjudged;
}

}  // namespace

bool IsSpanned(const Map& map, KeyframeId id) {
  const auto it = map.keyframes().find(id);
  if (it == map.keyframes().end() || it == map.keyframes().begin()) return false;
  const Keyframe& keyframe = it->second;
  if (!keyframe.parent.IsValid() || !keyframe.loop_edges.empty()) return false;
  const auto after = std::next(it);
  const auto before = std::prev(it);
  if (after == map.keyframes().end() || after->first.local_map != id.local_map) return false;
  if (before->first.local_map != id.local_map) return false;
  int points = 0;
  int seen = 0;
  for (const MapPointId point_id : before->second.points) {
    const MapPoint* point = map.FindPoint(point_id);
    if (point == nullptr || !IsSeenWellWithout(map, *point, id)) continue;
    ++points;
    seen += point->observations.contains(after->first);
  }
  return points > 0 && seen >= kSpannedShare * points;
}

std::vector<KeyframeId> KeyframeJudge::Judge(GuardedMap& guarded) {
  const std::vector<KeyframeId> unjudged =
      guarded.Read([&](const Map& map) { return FindUnjudged(map, guarded.local_map(), judged_); });
  std::vector<KeyframeId> removed;
  for (const KeyframeId id : unjudged) {
    judged_ = id.index;
    if (!guarded.Read([&](const Map& map) { return IsSpanned(map, id); })) continue;
    guarded.Write(
        [&](Map& map) { RemoveKeyframeAndItsPoints(id, map, WeakPoints::kThoseWithoutDepth); });
    removed.push_back(id);
  }
  return removed;
}

}  // namespace corbslam
