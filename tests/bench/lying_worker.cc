#include "tests/bench/lying_worker.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "fusion_worker/local_fusion_worker.h"
#include "slam/fusing/map_fusing.h"
#include "slam/geometry/lie.h"
#include "slam/util/status_macros.h"

namespace corbslam::tests {

using fusion_worker::MakeLocalFusionWorker;

namespace {

std::vector<MapPointId> PointsOf(const Map& map, KeyframeId id) {
  std::vector<MapPointId> points = map.FindKeyframe(id)->points;
  std::erase_if(points, [](MapPointId point) { return !point.IsValid(); });
  return points;
}

}  // namespace

LyingWorker::LyingWorker(std::optional<LieOptions> lie)
    : lie_(std::move(lie)),
      honest_(MakeLocalFusionWorker()),
      random_(lie_.has_value() ? lie_->seed : 0) {}

bool LyingWorker::IsLie(const Overlap& overlap) const {
  return told_.contains({overlap.query, overlap.candidate});
}

Rigid3d LyingWorker::Step() {
  Vector6d direction;
  std::normal_distribution<double> normal;
  for (int i = 0; i < 6; ++i) direction[i] = normal(random_);
  Vector6d step;
  step << lie_->shift_m * direction.head<3>().normalized(),
      lie_->turn_rad * direction.tail<3>().normalized();
  return ExpSE3(step);
}

// The first lie is a step from the true pose, where that was found; the others put the places where
// the maps lie.
Overlap LyingWorker::Lie(const VerifyOverlapRequest& request, const Overlap& honest) {
  Overlap lie = honest;
  if (told_.empty()) {
    const Similarity3d before =
        honest.IsAccepted() ? honest.candidate_from_query : Similarity3d::Identity();
    lie.candidate_from_query = Similarity3d::FromRigid(Step()) * before;
  } else {
    lie.candidate_from_query = Similarity3d::FromRigid(
        request.candidate_view.FindKeyframe(lie.candidate)->camera_from_map *
        request.query_view->FindKeyframe(lie.query)->camera_from_map.Inverse());
  }
  std::vector<MapPointId> of_query = PointsOf(*request.query_view, lie.query);
  std::vector<MapPointId> of_candidate = PointsOf(request.candidate_view, lie.candidate);
  std::shuffle(of_query.begin(), of_query.end(), random_);
  std::shuffle(of_candidate.begin(), of_candidate.end(), random_);
  const size_t pairs =
      std::min({of_query.size(), of_candidate.size(), static_cast<size_t>(lie_->wrong_pairs)});
  lie.inliers.clear();
  for (size_t i = 0; i < pairs; ++i) {
    if (of_query[i] != of_candidate[i]) lie.inliers.push_back({of_query[i], of_candidate[i]});
  }
  lie.verdict = OverlapVerdict::kAccepted;
  told_.emplace(lie.query, lie.candidate);
  return lie;
}

absl::StatusOr<VerifyOverlapResult> LyingWorker::VerifyOverlap(const VerifyOverlapRequest& request,
                                                               const ProgressCallback& progress) {
  ASSIGN_OR_RETURN(VerifyOverlapResult result, honest_->VerifyOverlap(request, progress));
  if (result.overlaps.empty()) return result;
  Overlap& last = result.overlaps.back();
  if (last.query.local_map == last.candidate.local_map) return result;
  const bool is_due = lie_.has_value() && verified_ >= lie_->after &&
                      told_.size() < static_cast<size_t>(lie_->lies);
  ++verified_;
  if (is_due) last = Lie(request, last);
  return result;
}

absl::StatusOr<FuseMapsResult> LyingWorker::FuseMaps(const FuseMapsRequest& request,
                                                     const ProgressCallback& progress) {
  const bool for_lie = std::any_of(request.new_overlaps.begin(), request.new_overlaps.end(),
                                   [&](size_t index) { return IsLie(request.overlaps.at(index)); });
  if (!for_lie) return honest_->FuseMaps(request, progress);
  MapFusingOptions gullible;
  gullible.max_edge_chi2 = std::numeric_limits<double>::infinity();
  gullible.max_drift = std::numeric_limits<double>::infinity();
  return corbslam::FuseMaps(request, gullible, progress);
}

}  // namespace corbslam::tests
