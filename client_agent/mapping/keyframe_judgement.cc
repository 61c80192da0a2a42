#include "client_agent/mapping/keyframe_judgement.h"

#include <iterator>

#include "client_agent/map/provisional_keyframes.h"
#include "client_agent/mapping/culling.h"

namespace corbslam::client_agent {
namespace {

constexpr double kRedundantShareOfProvisional = 0.7;
// Ground is known well where others know this share of the close points: a keyframe more adds
// little to what their looks average to (docs/adr/0041-known-ground-rests.md).
constexpr double kShareOfKnown = 0.4;
// Points that the neighbours of one that goes must have in common.
constexpr int kLeastToHoldTogether = 50;

// True if the own keyframes before and after this one see enough of the same without it.
bool NeighboursHoldTogether(const Map& map, KeyframeId id) {
  const auto it = map.keyframes().find(id);
  const auto after = std::next(it);
  if (it == map.keyframes().begin() || after == map.keyframes().end()) return false;
  const auto before = std::prev(it);
  if (before->first.local_map != id.local_map || after->first.local_map != id.local_map) {
    return false;
  }
  const auto common = before->second.covisible.find(after->first);
  return common != before->second.covisible.end() && common->second >= kLeastToHoldTogether;
}

bool IsOfKnownGround(const Map& map, const Keyframe& keyframe) {
  return MayGo(keyframe) && ShareKnownToOthers(map, keyframe) > kShareOfKnown &&
         NeighboursHoldTogether(map, keyframe.id());
}

bool IsSuperfluousAmongProvisional(const Map& map, const Keyframe& keyframe) {
  return MayGo(keyframe) && (IsRedundant(map, keyframe, kRedundantShareOfProvisional) ||
                             IsOfKnownGround(map, keyframe));
}

// Returns own keyframes beyond `judged` that are not among the newest so many, in order.
std::vector<KeyframeId> FindUnjudged(const Map& map, LocalMapId own,
                                     const std::optional<uint32_t>& judged, size_t but_newest) {
  std::vector<KeyframeId> unjudged;
  const KeyframeId last = NewestBut(map, own, but_newest);
  if (!last.IsValid()) return unjudged;
  const uint32_t first = judged.has_value() ? *judged + 1 : 0;
  for (auto it = map.keyframes().lower_bound({own, first});
       it != map.keyframes().end() && it->first <= last; ++it) {
    unjudged.push_back(it->first);
  }
  return unjudged;
}

}  // namespace

std::vector<KeyframeId> KeyframeJudge::Judge(GuardedMap& map) {
  return TakeOut(kProvisionalKeyframes, IsSuperfluousAmongProvisional, map);
}

std::vector<KeyframeId> KeyframeJudge::JudgeNewest(GuardedMap& map) {
  return TakeOut(0, IsOfKnownGround, map);
}

std::vector<KeyframeId> KeyframeJudge::TakeOut(size_t but_newest, Superfluous is_superfluous,
                                               GuardedMap& guarded) {
  const std::vector<KeyframeId> unjudged = guarded.Read(
      [&](const Map& map) { return FindUnjudged(map, guarded.local_map(), judged_, but_newest); });
  std::vector<KeyframeId> removed;
  for (const KeyframeId id : unjudged) {
    judged_ = id.index;
    const bool goes =
        guarded.Read([&](const Map& map) { return is_superfluous(map, *map.FindKeyframe(id)); });
    if (!goes) continue;
    guarded.Write([&](Map& map) { RemoveKeyframeAndItsPoints(id, map); });
    removed.push_back(id);
  }
  return removed;
}

}  // namespace corbslam::client_agent
