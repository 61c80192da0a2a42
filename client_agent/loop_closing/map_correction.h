// A correction of the robot's own map that was computed on a copy, and how it comes into the map
// that went on meanwhile.
#ifndef CORBSLAM_CLIENT_AGENT_LOOP_CLOSING_MAP_CORRECTION_H_
#define CORBSLAM_CLIENT_AGENT_LOOP_CLOSING_MAP_CORRECTION_H_

#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "absl/container/btree_set.h"
#include "client_agent/map/own_correction.h"
#include "slam/exchange/fusion_worker.h"
#include "slam/map/map.h"
#include "slam/optimisation/bundle_adjustment.h"

namespace corbslam::client_agent {

struct MapCorrection {
  struct MovedKeyframe {
    Rigid3d before;
    Similarity3d after;
  };
  struct MovedPoint {
    Eigen::Vector3d before = Eigen::Vector3d::Zero();
    Eigen::Vector3d after = Eigen::Vector3d::Zero();
  };
  // All own keyframes that were in the copy, moved or not.
  std::map<KeyframeId, MovedKeyframe> keyframes;
  std::map<MapPointId, MovedPoint> points;
  // Others' keyframes that were in the copy, held fixed, to which it was fitted.
  absl::btree_set<KeyframeId> fixed;
  std::vector<FuseMapsResult::Merge> merges;
  std::vector<RejectedObservation> rejected;
  // The loop that called for it.
  std::optional<std::pair<KeyframeId, KeyframeId>> loop_edge;
};

// Makes the correction of a loop closed on the copy `map`. Items of other local maps than `own` are
// left out.
MapCorrection MakeCorrection(const Map& map, LocalMapId own, const FuseMapsResult& fused);
// Makes the correction of a bundle adjustment of the copy `map`.
MapCorrection MakeCorrection(const Map& map, LocalMapId own, const BundleResult& adjusted);

// Moves own keyframes and points of `map`. What moved since the copy keeps that motion, what was
// born since follows the nearest corrected ancestor (keyframes) or its reference (points), and
// what is gone is skipped. Other local maps' items stay as they are. Then replaces duplicates,
// drops rejected observations of own keyframes and adds the loop edge. Returns how own keyframes
// moved.
std::map<KeyframeId, OwnCorrection::Motion> ApplyCorrection(const MapCorrection& correction,
                                                            LocalMapId own, Map& map);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LOOP_CLOSING_MAP_CORRECTION_H_
