// A fusion worker that finds everything as it should be.
#ifndef CORBSLAM_TESTS_FUZZ_AGREEABLE_WORKER_H_
#define CORBSLAM_TESTS_FUZZ_AGREEABLE_WORKER_H_

#include "slam/exchange/fusion_worker.h"

namespace corbslam::tests {

class AgreeableWorker : public FusionWorker {
 public:
  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest&,
                                                    const ProgressCallback&) override {
    return VerifyOverlapResult();
  }
  // Source and target are in one frame, and the pairs of all overlaps are landmarks.
  absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest& request,
                                          const ProgressCallback&) override {
    FuseMapsResult result;
    result.accepted = true;
    for (const auto& [id, keyframe] : request.source.keyframes()) {
      result.poses.push_back({id, Similarity3d::FromRigid(keyframe.camera_from_map)});
    }
    for (const Overlap& overlap : request.overlaps) {
      for (const PointPair& pair : overlap.inliers) {
        result.merges.push_back({pair.candidate, pair.query});
      }
    }
    return result;
  }
  // Everything moves a little; what the first keyframe sees is found to be wrong.
  absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest& request,
                                                  const ProgressCallback&) override {
    AdjustBundleResult result;
    for (const auto& [id, keyframe] : request.view.keyframes()) {
      Similarity3d pose = Similarity3d::FromRigid(keyframe.camera_from_map);
      pose.translation.x() += 1;
      result.poses.push_back({id, pose});
    }
    for (const auto& [id, point] : request.view.points()) {
      result.positions.push_back({id, point.position_in_map + Eigen::Vector3d(1, 0, 0)});
      if (point.observations.empty()) continue;
      result.rejected.push_back({id, point.observations.begin()->first});
    }
    return result;
  }
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_FUZZ_AGREEABLE_WORKER_H_
