#include "tests/bench/timed_worker.h"

#include <utility>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam::tests {
namespace {

double MillisecondsSince(absl::Time begin) {
  return absl::ToDoubleMilliseconds(absl::Now() - begin);
}

}  // namespace

absl::StatusOr<VerifyOverlapResult> TimedWorker::VerifyOverlap(const VerifyOverlapRequest& request,
                                                               const ProgressCallback& progress) {
  return worker_->VerifyOverlap(request, progress);
}

absl::StatusOr<FuseMapsResult> TimedWorker::FuseMaps(const FuseMapsRequest& request,
                                                     const ProgressCallback& progress) {
  const absl::Time begin = absl::Now();
  auto result = worker_->FuseMaps(request, progress);
  if (result.ok()) fusings_ms_.push_back(MillisecondsSince(begin));
  return result;
}

absl::StatusOr<AdjustBundleResult> TimedWorker::AdjustBundle(const AdjustBundleRequest& request,
                                                             const ProgressCallback& progress) {
  AdjustBundleRequest threaded = request;
  threaded.threads = threads_;
  const absl::Time begin = absl::Now();
  auto result = worker_->AdjustBundle(threaded, progress);
  const double ms = MillisecondsSince(begin);
  if (!result.ok()) return result;
  adjustments_.push_back({request.view.keyframes().size(), request.view.points().size(),
                          testing::CountObservations(request.view), result->iterations,
                          result->initial_cost, result->final_cost, ms});
  return result;
}

}  // namespace corbslam::tests
