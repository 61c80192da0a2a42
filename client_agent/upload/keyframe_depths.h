// Finds how deep keyframes lie in the spanning tree.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_KEYFRAME_DEPTHS_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_KEYFRAME_DEPTHS_H_

#include <cstddef>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "slam/map/map.h"

namespace corbslam::client_agent {

// The depths of keyframes in a map that does not change meanwhile. Each keyframe is looked at once,
// however many depths are asked for. Not thread-safe.
class KeyframeDepths {
 public:
  explicit KeyframeDepths(const Map& map) : map_(map) {}

  // Returns 1 for the root, 0 for a keyframe that is not in the map.
  size_t Of(KeyframeId id) {
    std::vector<KeyframeId> way;
    size_t depth = 0;
    for (const Keyframe* at = map_.FindKeyframe(id); at != nullptr;
         at = map_.FindKeyframe(at->parent)) {
      if (const auto known = depths_.find(at->id()); known != depths_.end()) {
        depth = known->second;
        break;
      }
      way.push_back(at->id());
    }
    for (auto it = way.rbegin(); it != way.rend(); ++it) depths_[*it] = ++depth;
    return depth;
  }

 private:
  const Map& map_;
  absl::flat_hash_map<KeyframeId, size_t> depths_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_KEYFRAME_DEPTHS_H_
