// A fusion worker that notes how long its requests took.
#ifndef CORBSLAM_TESTS_BENCH_TIMED_WORKER_H_
#define CORBSLAM_TESTS_BENCH_TIMED_WORKER_H_

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "slam/exchange/fusion_worker.h"

namespace corbslam::tests {

// Not thread-safe.
class TimedWorker : public FusionWorker {
 public:
  struct Adjustment {
    size_t keyframes = 0;
    size_t points = 0;
    size_t observations = 0;
    int iterations = 0;
    double initial_cost = 0;
    double final_cost = 0;
    double ms = 0;
  };

  // Adjusts with `threads`, whatever the request says.
  TimedWorker(std::unique_ptr<FusionWorker> worker, int threads)
      : worker_(std::move(worker)), threads_(threads) {}

  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest& request,
                                                    const ProgressCallback& progress) override;
  absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest& request,
                                          const ProgressCallback& progress) override;
  absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest& request,
                                                  const ProgressCallback& progress) override;

  // Durations of requests that were answered, in their order.
  const std::vector<double>& fusings_ms() const { return fusings_ms_; }
  const std::vector<Adjustment>& adjustments() const { return adjustments_; }

 private:
  const std::unique_ptr<FusionWorker> worker_;
  const int threads_;
  std::vector<double> fusings_ms_;
  std::vector<Adjustment> adjustments_;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_BENCH_TIMED_WORKER_H_
