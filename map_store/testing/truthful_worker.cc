#include "map_store/testing/truthful_worker.h"

#include <algorithm>
#include <utility>

#include "slam/util/status_macros.h"

namespace corbslam::testing {

TruthfulWorker::TruthfulWorker(const std::vector<const SyntheticMap*>& maps) {
  for (const SyntheticMap* made : maps) {
    camera_from_world_.insert(made->true_camera_from_world.begin(),
                              made->true_camera_from_world.end());
    world_point_.insert(made->world_point.begin(), made->world_point.end());
  }
}

std::vector<TruthfulWorker::Asked> TruthfulWorker::asked() const {
  absl::MutexLock lock(&mutex_);
  return asked_;
}
std::vector<FuseMapsRequest> TruthfulWorker::fused() const {
  absl::MutexLock lock(&mutex_);
  return fused_;
}
std::vector<AdjustBundleRequest> TruthfulWorker::adjusted() const {
  absl::MutexLock lock(&mutex_);
  return adjusted_;
}

absl::Status TruthfulWorker::TakeFailure(std::deque<absl::Status>& failures) {
  absl::MutexLock lock(&mutex_);
  if (failures.empty()) return absl::OkStatus();
  const absl::Status failure = failures.front();
  failures.pop_front();
  return failure;
}

bool TruthfulWorker::HasBendingOverlap(const FuseMapsRequest& request) const {
  return bends_graph != nullptr && std::ranges::any_of(request.new_overlaps, [&](size_t index) {
           return bends_graph(request.overlaps.at(index));
         });
}

bool TruthfulWorker::TakeLie(const Overlap& overlap) {
  absl::MutexLock lock(&mutex_);
  const bool lies = !has_lied_ && lies_about.IsValid() && !overlap.IsAccepted() &&
                    overlap.query.local_map == lies_about &&
                    overlap.candidate.local_map != lies_about;
  has_lied_ = has_lied_ || lies;
  return lies;
}

Overlap TruthfulWorker::Compare(const VerifyOverlapRequest& request, KeyframeId candidate) const {
  const Rigid3d& query_pose = camera_from_world_.at(request.query);
  const Rigid3d& candidate_pose = camera_from_world_.at(candidate);
  Overlap overlap;
  overlap.query = request.query;
  overlap.candidate = candidate;
  const Rigid3d candidate_from_query = candidate_pose * query_pose.Inverse();
  overlap.candidate_from_query = Similarity3d::FromRigid(candidate_from_query);
  if (candidate_from_query.translation.norm() > same_place_m) return overlap;
  std::map<size_t, MapPointId> seen;
  for (const MapPointId& id : request.candidate_view.FindKeyframe(candidate)->points) {
    if (id.IsValid()) seen[world_point_.at(id)] = id;
  }
  for (const MapPointId& id : request.query_view->FindKeyframe(request.query)->points) {
    if (!id.IsValid()) continue;
    const auto it = seen.find(world_point_.at(id));
    if (it != seen.end() && it->second != id) overlap.inliers.push_back({id, it->second});
  }
  overlap.verdict = OverlapVerdict::kAccepted;
  overlap.evidence.refined_inliers = static_cast<int>(overlap.inliers.size());
  return overlap;
}

absl::StatusOr<VerifyOverlapResult> TruthfulWorker::VerifyOverlap(
    const VerifyOverlapRequest& request, const ProgressCallback&) {
  if (during_verify) during_verify();
  RETURN_IF_ERROR(TakeFailure(verify_failures));
  VerifyOverlapResult result;
  Asked asked = {request.query, {}};
  for (const VerifyOverlapRequest::Candidate& candidate : request.candidates) {
    asked.candidates.push_back(candidate.id);
    result.overlaps.push_back(Compare(request, candidate.id));
    Overlap& overlap = result.overlaps.back();
    if (TakeLie(overlap)) overlap.verdict = OverlapVerdict::kAccepted;
    if (result.overlaps.back().IsAccepted()) break;
  }
  absl::MutexLock lock(&mutex_);
  asked_.push_back(std::move(asked));
  return result;
}

absl::StatusOr<FuseMapsResult> TruthfulWorker::FuseMaps(const FuseMapsRequest& request,
                                                        const ProgressCallback&) {
  if (during_fuse) during_fuse();
  RETURN_IF_ERROR(TakeFailure(fuse_failures));
  FuseMapsResult result;
  result.accepted = !refuse_fusing && !HasBendingOverlap(request);
  const Overlap& overlap = request.overlaps.at(request.new_overlaps.at(0));
  Similarity3d candidate_from_query = overlap.candidate_from_query;
  KeyframeId in_target = overlap.candidate;
  KeyframeId in_source = overlap.query;
  if (request.target.FindKeyframe(in_target) == nullptr) {
    std::swap(in_target, in_source);
    candidate_from_query = candidate_from_query.Inverse();
  }
  if (const Keyframe* source = request.source.FindKeyframe(in_source)) {
    result.target_from_source =
        Similarity3d::FromRigid(request.target.FindKeyframe(in_target)->camera_from_map).Inverse() *
        candidate_from_query * Similarity3d::FromRigid(source->camera_from_map);
  }
  for (const auto& [id, keyframe] : request.source.keyframes()) {
    result.poses.push_back({id, Similarity3d::FromRigid(keyframe.camera_from_map) *
                                    result.target_from_source.Inverse()});
  }
  for (const auto& [id, point] : request.source.points()) {
    result.positions.push_back({id, result.target_from_source * point.position_in_map});
  }
  for (const size_t index : request.new_overlaps) {
    for (const PointPair& pair : request.overlaps[index].inliers) {
      const bool candidate_stays = request.target.FindPoint(pair.candidate) != nullptr;
      result.merges.push_back({candidate_stays ? pair.candidate : pair.query,
                               candidate_stays ? pair.query : pair.candidate});
    }
  }
  absl::MutexLock lock(&mutex_);
  fused_.push_back(request);
  return result;
}

absl::StatusOr<AdjustBundleResult> TruthfulWorker::AdjustBundle(const AdjustBundleRequest& request,
                                                                const ProgressCallback& progress) {
  if (during_adjust && !during_adjust(progress)) return absl::CancelledError("cancelled");
  RETURN_IF_ERROR(TakeFailure(adjust_failures));
  const KeyframeId fixed = request.fixed.at(0);
  const Rigid3d world_from_map =
      camera_from_world_.at(fixed).Inverse() * request.view.FindKeyframe(fixed)->camera_from_map;
  AdjustBundleResult result;
  for (const auto& [id, keyframe] : request.view.keyframes()) {
    result.poses.push_back(
        {id, Similarity3d::FromRigid(camera_from_world_.at(id) * world_from_map)});
  }
  result.rejected = reject;
  result.redundant = redundant;
  result.keyframes = static_cast<int>(request.view.keyframes().size());
  result.points = static_cast<int>(request.view.points().size());
  absl::MutexLock lock(&mutex_);
  adjusted_.push_back(request);
  return result;
}

}  // namespace corbslam::testing
