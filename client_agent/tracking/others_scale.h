// Holds others' maps against the distances that the robot's own camera measures.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_OTHERS_SCALE_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_OTHERS_SCALE_H_

#include <map>
#include <optional>
#include <set>
#include <vector>

#include "absl/container/flat_hash_set.h"
#include "client_agent/tracking/frame.h"
#include "slam/exchange/agent_report.h"
#include "slam/util/ids.h"

namespace corbslam::client_agent {

// A pose follows others' points wherever they are, and nothing that a pixel shows tells a map that
// is too large from a right one; disparities do, because they are the robot's own. A map that is
// wrong by some per mille costs a robot that drives by it more than it gives
// (docs/adr/0042-others-distances.md). Not thread-safe.
class OthersScale {
 public:
  // Looks at a frame that was tracked. `own` is the robot's local map. Returns those of others'
  // local maps of which it is certain from now on; each once.
  std::vector<MapContradiction> Add(const Frame& frame, LocalMapId own);

 private:
  // Frames one after the other are wrong in the same way (the same edges, the same part of the
  // lens), so that what counts are means over blocks of them.
  struct Block {
    int frames = 0;
    double log_scale = 0;
    double sigma = 0;   // Of one frame, as its points scatter.
    double points = 0;  // In one frame.
    absl::flat_hash_set<MapPointId> seen;
  };
  struct Evidence {
    Block growing;
    std::vector<Block> blocks;
  };
  // Ends the block that grows; returns what is certain by it.
  static std::optional<MapContradiction> Judge(LocalMapId local_map, Evidence& evidence);

  std::map<LocalMapId, Evidence> evidence_;
  std::set<LocalMapId> contradicting_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_OTHERS_SCALE_H_
