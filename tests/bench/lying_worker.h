// A fusion worker that says of one pair of places that they are the same, which they are not.
#ifndef CORBSLAM_TESTS_BENCH_LYING_WORKER_H_
#define CORBSLAM_TESTS_BENCH_LYING_WORKER_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <utility>

#include "slam/exchange/fusion_worker.h"

namespace corbslam {

struct LieOptions {
  // Verified places of two different local maps before the one that is lied about.
  int after = 0;
  // How far from where they are the two places are said to be, from each other.
  double shift_m = 5;
  double turn_rad = 0.2;
  int wrong_pairs = 30;  // Of points that have nothing to do with each other.
  uint64_t seed = 1;
};

// All else is the local worker's. Fuses what the lie calls for even where it contradicts the graph.
// Not thread-safe.
class LyingWorker : public FusionWorker {
 public:
  explicit LyingWorker(std::optional<LieOptions> lie);

  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest& request,
                                                    const ProgressCallback& progress) override;
  absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest& request,
                                          const ProgressCallback& progress) override;
  absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest& request,
                                                  const ProgressCallback& progress) override {
    return honest_->AdjustBundle(request, progress);
  }

  // Places of different local maps that were verified.
  int verified() const { return verified_; }
  // Query and candidate of the lie, once it was told.
  const std::optional<std::pair<KeyframeId, KeyframeId>>& told() const { return told_; }

 private:
  Overlap Lie(const VerifyOverlapRequest& request, const Overlap& honest);
  bool IsLie(const Overlap& overlap) const;

  const std::optional<LieOptions> lie_;
  const std::unique_ptr<FusionWorker> honest_;
  std::mt19937_64 random_;
  int verified_ = 0;
  std::optional<std::pair<KeyframeId, KeyframeId>> told_;
};

}  // namespace corbslam

#endif  // CORBSLAM_TESTS_BENCH_LYING_WORKER_H_
