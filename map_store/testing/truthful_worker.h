// A fusion worker for tests. It looks up the truth instead of estimating it, counts what it is
// asked, and fails on demand.
#ifndef CORBSLAM_MAP_STORE_TESTING_TRUTHFUL_WORKER_H_
#define CORBSLAM_MAP_STORE_TESTING_TRUTHFUL_WORKER_H_

#include <deque>
#include <functional>
#include <map>
#include <vector>

#include "absl/synchronization/mutex.h"
#include "slam/exchange/fusion_worker.h"
#include "slam/verification/testing/synthetic_world.h"

namespace corbslam::testing {

// Thread-safe once its fields are set.
class TruthfulWorker : public FusionWorker {
 public:
  // All maps must show the same world.
  explicit TruthfulWorker(const std::vector<const SyntheticMap*>& maps);

  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest& request,
                                                    const ProgressCallback& progress) override;
  absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest& request,
                                          const ProgressCallback& progress) override;
  absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest& request,
                                                  const ProgressCallback& progress) override;

  struct Asked {
    KeyframeId query;
    std::vector<KeyframeId> candidates;
  };
  std::vector<Asked> asked() const;
  std::vector<FuseMapsRequest> fused() const;
  std::vector<AdjustBundleRequest> adjusted() const;

  // Functions that are called while a request runs, without a lock.
  std::function<void()> during_verify;
  std::function<void()> during_fuse;
  std::function<bool(const ProgressCallback&)> during_adjust;
  // Each of these answers one of the next requests of the kind.
  std::deque<absl::Status> verify_failures;
  std::deque<absl::Status> fuse_failures;
  std::deque<absl::Status> adjust_failures;
  bool refuse_fusing = false;
  // Fusing is refused if this is true for any of the request's new overlaps.
  std::function<bool(const Overlap&)> bends_graph;
  // Once, the worker accepts an overlap wrongly: the first one that a keyframe of this local map
  // asks of another local map. Invalid: it never does.
  LocalMapId lies_about;
  // Observations that an adjustment finds to be wrong.
  std::vector<RejectedObservation> reject;
  std::vector<KeyframeId> redundant;
  // Keyframes farther apart than this, in metres, show different places.
  double same_place_m = 4;

 private:
  absl::Status TakeFailure(std::deque<absl::Status>& failures);
  // Returns whether the worker is to accept this overlap wrongly; true once at most.
  bool TakeLie(const Overlap& overlap);
  bool HasBendingOverlap(const FuseMapsRequest& request) const;
  Overlap Compare(const VerifyOverlapRequest& request, KeyframeId candidate) const;

  std::map<KeyframeId, Rigid3d> camera_from_world_;
  std::map<MapPointId, size_t> world_point_;

  mutable absl::Mutex mutex_;
  bool has_lied_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<Asked> asked_ ABSL_GUARDED_BY(mutex_);
  std::vector<FuseMapsRequest> fused_ ABSL_GUARDED_BY(mutex_);
  std::vector<AdjustBundleRequest> adjusted_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_TRUTHFUL_WORKER_H_
