// Whether a keyframe is worth keeping, once the camera has gone on.
#ifndef CORBSLAM_CLIENT_AGENT_MAPPING_KEYFRAME_JUDGEMENT_H_
#define CORBSLAM_CLIENT_AGENT_MAPPING_KEYFRAME_JUDGEMENT_H_

#include <optional>
#include <vector>

#include "client_agent/map/guarded_map.h"
#include "slam/map/map.h"

namespace corbslam {

// True if the own keyframes before and after this one hold together without it: of the points of
// the one before that are well seen, the one after sees three quarters, as tracking asks of a frame
// before it makes no keyframe of it (docs/adr/0012-provisional-keyframes.md). Not the root, none
// that holds a loop edge. Pure.
bool IsSpanned(const Map& map, KeyframeId id);

// Takes out those keyframes that turn out not to be needed as they leave the newest
// kProvisionalKeyframes. Not thread-safe: the mapping thread's.
class KeyframeJudge {
 public:
  // Judges what has left since the last call, the oldest first; returns what was taken out. Points
  // that another keyframe sees with depth stay.
  std::vector<KeyframeId> Judge(GuardedMap& map);

 private:
  // The last one that was judged.
  std::optional<uint32_t> judged_;
};

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_MAPPING_KEYFRAME_JUDGEMENT_H_
