// Weighs what others say of where points are by how well it fits the robot's own sight
// (docs/adr/0040-others-map-is-evidence.md).
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_OTHERS_TRUST_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_OTHERS_TRUST_H_

#include <map>
#include <optional>
#include <vector>

#include "absl/container/flat_hash_set.h"
#include "client_agent/tracking/frame.h"
#include "slam/util/ids.h"

namespace corbslam::client_agent {

// How the hearsay of one of others' local maps lies to a frame whose pose rests on the robot's
// own sight alone.
struct Innovation {
  LocalMapId local_map;
  // Median of their squared errors, in units of the median of those of the points that the pose
  // rests on.
  double ratio = 1;
};

// That one of others' local maps begins to contradict the robot's own sight, or fits it again.
struct OthersNews {
  LocalMapId local_map;
  bool contradicts = false;
  // By so many times the own points' error the others' miss the pictures.
  double deviations = 1;
};

// Returns the innovation of each of others' local maps that a frame sees enough of. `hearsay` are
// the points of which others alone say where they are (LocalMapView). Nullopt where there is none,
// or what the robot locates by itself does not determine the frame's pose. Costs a pose
// optimisation.
std::optional<std::vector<Innovation>> MeasureInnovations(
    const Frame& frame, const absl::flat_hash_set<MapPointId>& hearsay);

// Remembers over some frames how well each of others' local maps fits. Not thread-safe.
class OthersTrust {
 public:
  // Gives the frame's associations with hearsay their variances. Those of a local map that
  // contradicts are dropped, if there are innovations: else nothing says that the frame's pose is
  // known without them.
  void Weigh(const absl::flat_hash_set<MapPointId>& hearsay, bool has_innovations,
             Frame& frame) const;

  // Takes in what a frame showed. Returns what is new by it.
  std::vector<OthersNews> Add(const std::vector<Innovation>& innovations);

 private:
  struct Belief {
    // Of a keypoint's error against hearsay, in units of that against what own keyframes locate.
    double variance = 1;
    bool contradicts = false;
  };
  std::map<LocalMapId, Belief> beliefs_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_OTHERS_TRUST_H_
