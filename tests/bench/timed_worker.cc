#include "tests/bench/timed_worker.h"

#include <utility>

#include "absl/time/clock.h"
#include "absl/time/time.h"

namespace corbslam {
namespace {

double MillisecondsSince(absl::Time begin) {
  return absl::ToDoubleMilliseconds(absl::Now() - begin);
}

size_t CountObservations(const Map& map) {
  size_t count = 0;
  for (const auto& [id, point] : map.points()) count += point.observations.size();
  return count;
}

}  // namespace

absl::StatusOr<VerifyOverlapResult> TimedWorker::VerifyOverlap(const VerifyOverlapRequest& request,
                                                               const ProgressCallback& progress) {
  const absl::Time begin = absl::Now();
  auto result = worker_->VerifyOverlap(request, progress);
  verifications_ms_.push_back(MillisecondsSince(begin));
  return result;
}

absl::StatusOr<FuseMapsResult> TimedWorker::FuseMaps(const FuseMapsRequest& request,
                                                     const ProgressCallback& progress) {
  const absl::Time begin = absl::Now();
  auto result = worker_->FuseMaps(request, progress);
  if (!result.ok()) return result;
  fusings_.push_back({request.target.keyframes().size() + request.source.keyframes().size(),
                      MillisecondsSince(begin), result->accepted});
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
                          CountObservations(request.view), result->iterations, result->initial_cost,
                          result->final_cost, ms});
  return result;
}

}  // namespace corbslam
