#include "fusion_worker/local_fusion_worker.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "fusion_worker/view_validation.h"
#include "slam/fusing/map_fusing.h"
#include "slam/fusing/redundant_keyframes.h"
#include "slam/optimisation/bundle_adjustment.h"
#include "slam/sensor/picture_features.h"
#include "slam/util/status_macros.h"
#include "slam/verification/frame_location.h"
#include "slam/verification/place_verification.h"

namespace corbslam::fusion_worker {
namespace {

constexpr int kMaxIterations = 1000;
// The first round finds the outliers, the second adjusts without them, and the third with those
// that turn out not to be any.
constexpr int kOutlierRounds = 2;
// Bends over hundreds of keyframes hardly show in the cost: at 1e-5 a street's map was called
// converged with a sixth of its error, size aside, to go.
constexpr double kConvergedCostChange = 1e-6;

bool IsCancelled(const ProgressCallback& progress, double part) {
  return progress != nullptr && !progress(part);
}

class LocalFusionWorker : public FusionWorker {
 public:
  explicit LocalFusionWorker(const FusionWorkerOptions& options) : options_(options) {}

  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest& request,
                                                    const ProgressCallback& progress) override;
  absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest& request,
                                          const ProgressCallback& progress) override;
  absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest& request,
                                                  const ProgressCallback& progress) override;
  absl::StatusOr<LocateFrameResult> LocateFrame(const LocateFrameRequest& request,
                                                const ProgressCallback& progress) override;
  absl::StatusOr<ExtractFeaturesResult> ExtractFeatures(
      const ExtractFeaturesRequest& request) override;

 private:
  const FusionWorkerOptions options_;
};

absl::Status CheckCandidates(const VerifyOverlapRequest& request) {
  if (request.query_view->FindKeyframe(request.query) == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat("query keyframe ", ToString(request.query), " is not in its view"));
  }
  for (const VerifyOverlapRequest::Candidate& candidate : request.candidates) {
    if (candidate.id == request.query) {
      return absl::InvalidArgumentError(
          absl::StrCat("keyframe ", ToString(candidate.id), " is a candidate for itself"));
    }
    if (request.candidate_view.FindKeyframe(candidate.id) == nullptr) {
      return absl::InvalidArgumentError(
          absl::StrCat("candidate keyframe ", ToString(candidate.id), " is not in its view"));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<VerifyOverlapResult> LocalFusionWorker::VerifyOverlap(
    const VerifyOverlapRequest& request, const ProgressCallback& progress) {
  RETURN_IF_ERROR(CheckCandidates(request));
  RETURN_IF_ERROR(CheckView(*request.query_view));
  RETURN_IF_ERROR(CheckView(request.candidate_view));
  PlaceVerificationOptions verification;
  verification.fix_scale = request.fix_scale;
  verification.seed = options_.seed;
  VerifyOverlapResult result;
  result.base_revision = request.base_revision;
  for (const VerifyOverlapRequest::Candidate& candidate : request.candidates) {
    const double done = static_cast<double>(result.overlaps.size());
    if (IsCancelled(progress, done / static_cast<double>(request.candidates.size()))) {
      return absl::CancelledError(
          absl::StrCat("verification of keyframe ", ToString(request.query), " was cancelled"));
    }
    result.overlaps.push_back(VerifyPlace(*request.query_view, request.query,
                                          request.candidate_view, candidate.id, verification));
    result.overlaps.back().evidence.shared_words = candidate.shared_words;
    if (result.overlaps.back().IsAccepted()) break;
  }
  return result;
}

absl::StatusOr<FuseMapsResult> LocalFusionWorker::FuseMaps(const FuseMapsRequest& request,
                                                           const ProgressCallback& progress) {
  RETURN_IF_ERROR(CheckView(request.target));
  RETURN_IF_ERROR(CheckView(request.source));
  MapFusingOptions fusing;
  fusing.threads = std::max(options_.threads, 1);
  return corbslam::FuseMaps(request, fusing, progress);
}

absl::Status CheckAdjustment(const AdjustBundleRequest& request) {
  if (request.fixed.empty()) {
    return absl::InvalidArgumentError("bundle adjustment needs a fixed keyframe");
  }
  for (const KeyframeId& id : request.fixed) {
    if (request.view.FindKeyframe(id) != nullptr) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("fixed keyframe ", ToString(id), " is not in the view"));
  }
  if (request.max_iterations < 1 || request.max_iterations > kMaxIterations) {
    return absl::InvalidArgumentError(absl::StrCat("max_iterations is ", request.max_iterations,
                                                   ", must be 1 to ", kMaxIterations));
  }
  if (!(request.redundant_share >= 0 && request.redundant_share <= 1)) {
    return absl::InvalidArgumentError(
        absl::StrCat("redundant_share is ", request.redundant_share, ", must be 0 to 1"));
  }
  return CheckView(request.view);
}

AdjustBundleResult MakeResult(const AdjustBundleRequest& request, const BundleScope& scope,
                              const BundleResult& adjusted) {
  AdjustBundleResult result;
  result.base_revision = request.base_revision;
  for (const PoseUpdate& update : adjusted.poses) {
    result.poses.push_back({update.id, Similarity3d::FromRigid(update.camera_from_map)});
  }
  for (const PositionUpdate& update : adjusted.positions) {
    result.positions.push_back({update.id, update.position_in_map});
  }
  for (const ObservationKey& outlier : adjusted.outliers) {
    result.rejected.push_back({outlier.point, outlier.keyframe});
  }
  result.keyframes = static_cast<int>(scope.free_keyframes.size() + scope.fixed_keyframes.size());
  result.points = static_cast<int>(scope.free_points.size());
  result.iterations = adjusted.iterations;
  result.initial_cost = adjusted.initial_cost;
  result.final_cost = adjusted.final_cost;
  return result;
}

absl::StatusOr<AdjustBundleResult> LocalFusionWorker::AdjustBundle(
    const AdjustBundleRequest& request, const ProgressCallback& progress) {
  RETURN_IF_ERROR(CheckAdjustment(request));
  const absl::Time begin = absl::Now();
  const BundleScope scope = GlobalBundleScope(request.view, request.fixed);
  BundleOptions bundle;
  // The request counts the iterations of all rounds together.
  bundle.max_iterations = (request.max_iterations + kOutlierRounds) / (kOutlierRounds + 1);
  bundle.outlier_rounds = kOutlierRounds;
  bundle.measure_noise = true;
  bundle.converged_cost_change = kConvergedCostChange;
  bundle.threads = std::max(request.threads, 1);
  bundle.keep_going = [&](double part) { return !IsCancelled(progress, part); };
  ASSIGN_OR_RETURN(const BundleResult adjusted,
                   corbslam::AdjustBundle(request.view, scope, bundle));
  if (adjusted.cancelled) return absl::CancelledError("bundle adjustment was cancelled");
  AdjustBundleResult result = MakeResult(request, scope, adjusted);
  result.redundant = FindRedundantKeyframes(
      request.view, {request.fixed.begin(), request.fixed.end()},
      {.seen_share = request.redundant_share, .target_keyframes = request.target_keyframes});
  result.seconds = absl::ToDoubleSeconds(absl::Now() - begin);
  return result;
}

absl::Status CheckFrame(const LocateFrameRequest& request) {
  const Keyframe& frame = request.frame;
  if (frame.payload == nullptr || frame.payload->camera == nullptr) {
    return absl::InvalidArgumentError("the picture to be located has no camera");
  }
  RETURN_IF_ERROR(Validate(frame.camera()));
  if (frame.descriptors().size() != frame.keypoints().size()) {
    return absl::InvalidArgumentError(absl::StrCat("the picture to be located has ",
                                                   frame.descriptors().size(), " descriptors for ",
                                                   frame.keypoints().size(), " keypoints"));
  }
  for (const LocateFrameRequest::Candidate& candidate : request.candidates) {
    if (request.view.FindKeyframe(candidate.id) != nullptr) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("candidate keyframe ", ToString(candidate.id), " is not in the view"));
  }
  return CheckView(request.view);
}

absl::StatusOr<LocateFrameResult> LocalFusionWorker::LocateFrame(const LocateFrameRequest& request,
                                                                 const ProgressCallback& progress) {
  RETURN_IF_ERROR(CheckFrame(request));
  bool cancelled = false;
  LocateFrameResult result =
      corbslam::LocateFrame(request, {.seed = options_.seed}, [&](double part) {
        cancelled = IsCancelled(progress, part);
        return !cancelled;
      });
  if (cancelled) return absl::CancelledError("the search for a picture's place was cancelled");
  return result;
}

absl::StatusOr<ExtractFeaturesResult> LocalFusionWorker::ExtractFeatures(
    const ExtractFeaturesRequest& request) {
  ASSIGN_OR_RETURN(const cv::Mat grey, DecodePicture(request.encoded));
  ASSIGN_OR_RETURN(PictureFeatures found,
                   FindPictureFeatures(grey, request.camera, request.features));
  return ExtractFeaturesResult{std::move(found.features), found.camera};
}

}  // namespace

std::unique_ptr<FusionWorker> MakeLocalFusionWorker(const FusionWorkerOptions& options) {
  return std::make_unique<LocalFusionWorker>(options);
}

}  // namespace corbslam::fusion_worker
