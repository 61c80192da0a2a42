// A fusion worker that says of some pairs of places that they are the same, which they are not.
#ifndef CORBSLAM_TESTS_BENCH_LYING_WORKER_H_
#define CORBSLAM_TESTS_BENCH_LYING_WORKER_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <utility>

#include "slam/exchange/fusion_worker.h"

namespace corbslam::tests {

struct LieOptions {
  // Number of verified places of two different local maps before the first that is lied about.
  int after = 0;
  // Number of lies: one, and others that stand by it. Each of these says that its places are where
  // the first one has led, as happens where two streets look alike for a while.
  int lies = 1;
  // The two places are said to be so far from where they are, relative to each other.
  double shift_m = 5;
  double turn_rad = 0.2;
  int wrong_pairs = 30;  // Pairs of points that have nothing to do with each other.
  uint64_t seed = 1;
};

// The local worker does everything else. It fuses what the lie calls for even where that
// contradicts the graph. Not thread-safe.
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

  // Number of places of different local maps that were verified.
  int verified() const { return verified_; }
  // Returns whether the worker made it up.
  bool IsLie(const Overlap& overlap) const;

 private:
  Rigid3d Step();
  Overlap Lie(const VerifyOverlapRequest& request, const Overlap& honest);

  const std::optional<LieOptions> lie_;
  const std::unique_ptr<FusionWorker> honest_;
  std::mt19937_64 random_;
  int verified_ = 0;
  std::set<std::pair<KeyframeId, KeyframeId>> told_;  // Queries and candidates of the lies.
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_BENCH_LYING_WORKER_H_
