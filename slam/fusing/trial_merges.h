// Points that are merged on trial: whether two are one shows in an adjustment.
#ifndef CORBSLAM_SLAM_FUSING_TRIAL_MERGES_H_
#define CORBSLAM_SLAM_FUSING_TRIAL_MERGES_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "slam/exchange/fusion_worker.h"
#include "slam/fusing/welding.h"
#include "slam/map/map.h"
#include "slam/optimisation/bundle_adjustment.h"

namespace corbslam {

struct TrialMerge {
  // One of the two points as it was before.
  struct Side {
    Eigen::Vector3d position_in_map;
    std::vector<KeyframeId> observers;
  };
  FuseMapsResult::Merge merge;
  Side survivor;
  Side member;
};

// Merges in `map`; none where it has only one of the two.
std::optional<TrialMerge> MergeOnTrial(const FuseMapsResult::Merge& merge, Map& map);

// What `adjusted` says of `map`, with the merges that it agrees with. Where most of what saw one of
// the two are outliers, they are two: each keeps its observations, and those that the adjustment
// left out go with a keyframe that sees them.
WeldingResult JudgeMerges(const std::vector<TrialMerge>& trials, const Map& map,
                          const BundleResult& adjusted);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_FUSING_TRIAL_MERGES_H_
