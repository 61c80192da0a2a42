// Judges whether a keyframe was worth making, once the camera has gone on.
#ifndef CORBSLAM_CLIENT_AGENT_MAPPING_KEYFRAME_JUDGEMENT_H_
#define CORBSLAM_CLIENT_AGENT_MAPPING_KEYFRAME_JUDGEMENT_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "client_agent/map/guarded_map.h"

namespace corbslam::client_agent {

// Takes out those own keyframes that turn out to be redundant as they leave the newest
// kProvisionalKeyframes, or that say little of ground which others know well and that the own
// neighbours hold together without. Nobody has been told of them yet, so they go more easily than
// those that stayed (culling.h; docs/adr/0012-provisional-keyframes.md). Not thread-safe: the
// mapping thread uses it.
class KeyframeJudge {
 public:
  // Judges the keyframes that have left since the last call, the oldest first; returns those it
  // took out.
  std::vector<KeyframeId> Judge(GuardedMap& map);
  // The same for the newest, of a local map that ends: of these only what others know goes.
  std::vector<KeyframeId> JudgeNewest(GuardedMap& map);

 private:
  using Superfluous = bool (*)(const Map&, const Keyframe&);
  std::vector<KeyframeId> TakeOut(size_t but_newest, Superfluous is_superfluous, GuardedMap& map);

  // The last one that was judged.
  std::optional<uint32_t> judged_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_MAPPING_KEYFRAME_JUDGEMENT_H_
