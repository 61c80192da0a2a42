#include "client_agent/mapping/keyframe_judgement.h"

#include "client_agent/map/provisional_keyframes.h"
#include "client_agent/mapping/culling.h"

namespace corbslam::client_agent {
namespace {

constexpr double kRedundantShareOfProvisional = 0.7;

// Returns own keyframes beyond `judged` that are not among the newest, in order.
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

std::vector<KeyframeId> KeyframeJudge::Judge(GuardedMap& guarded) {
  const std::vector<KeyframeId> unjudged =
      guarded.Read([&](const Map& map) { return FindUnjudged(map, guarded.local_map(), judged_); });
  std::vector<KeyframeId> removed;
  for (const KeyframeId id : unjudged) {
    judged_ = id.index;
    const bool is_redundant = guarded.Read([&](const Map& map) {
      const Keyframe& keyframe = *map.FindKeyframe(id);
      return MayGo(keyframe) && IsRedundant(map, keyframe, kRedundantShareOfProvisional);
    });
    if (!is_redundant) continue;
    guarded.Write([&](Map& map) { RemoveKeyframeAndItsPoints(id, map); });
    removed.push_back(id);
  }
  return removed;
}

}  // namespace corbslam::client_agent
