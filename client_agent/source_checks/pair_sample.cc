#include "client_agent/source_checks/pair_sample.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "slam/util/median.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

// With fewer features nothing tells whether matches are missing or were never to be had.
constexpr size_t kMinFeatures = 100;

bool HasEnough(const CheckFeatures& side) { return side.features.keypoints.size() >= kMinFeatures; }

// Matches with rows farther apart are taken for wrong ones.
constexpr double kMostRows_px = 40;

bool IsFarApart(const FeatureMatch& match) {
  return std::abs(match.in_b.y() - match.in_a.y()) > kMostRows_px;
}

bool HasSize(const cv::Mat& grey, const Camera& camera) {
  return grey.type() == CV_8UC1 && grey.cols == camera.width_px && grey.rows == camera.height_px;
}

}  // namespace

absl::StatusOr<PairPreparation> PairPreparation::Make(const StereoCalibration& calibration) {
  PairPreparation preparation;
  preparation.camera_ = calibration.camera;
  preparation.right_cx_offset_px_ = calibration.right_cx_offset_px;
  if (calibration.raw.has_value()) {
    ASSIGN_OR_RETURN(preparation.rectifier_, StereoRectifier::Make(*calibration.raw));
    preparation.camera_ = preparation.rectifier_->camera();
  }
  return preparation;
}

std::optional<PairPreparation::Pictures> PairPreparation::Rectify(const SensorImages& images,
                                                                  bool exchanged) const {
  const cv::Mat& left = exchanged ? images.right : images.grey;
  const cv::Mat& right = exchanged ? images.grey : images.right;
  if (!HasSize(left, camera_) || !HasSize(right, camera_)) return std::nullopt;
  if (!rectifier_.has_value()) return Pictures{left, right};
  Pictures rectified;
  if (!rectifier_->RectifyLeft(left, rectified.left).ok() ||
      !rectifier_->RectifyRight(right, rectified.right).ok()) {
    return std::nullopt;
  }
  return rectified;
}

std::optional<PairPreparation::Sides> PairPreparation::Extract(const SensorImages& images,
                                                               bool exchanged) const {
  const std::optional<Pictures> pictures = Rectify(images, exchanged);
  if (!pictures.has_value()) return std::nullopt;
  Sides sides{ExtractCheckFeatures(pictures->left), ExtractCheckFeatures(pictures->right)};
  for (Keypoint& keypoint : sides.right.features.keypoints) {
    keypoint.x_px -= static_cast<float>(right_cx_offset_px_);
  }
  return sides;
}

std::optional<std::vector<FeatureMatch>> PairPreparation::Match(
    const std::optional<Sides>& left, const std::optional<Sides>& right) const {
  if (!left.has_value() || !right.has_value()) return std::nullopt;
  if (!HasEnough(left->left) || !HasEnough(right->right)) return std::nullopt;
  return MatchFeatures(left->left, right->right);
}

PairEvidence PairPreparation::Weigh(const Sides& left, const Sides& right,
                                    const std::vector<FeatureMatch>& matches) const {
  return GatherPairEvidence(
      std::min(left.left.features.keypoints.size(), right.right.features.keypoints.size()), matches,
      {camera_.width_px, camera_.height_px});
}

std::optional<PairEvidence> PairPreparation::Compare(const std::optional<Sides>& left,
                                                     const std::optional<Sides>& right) const {
  const auto matches = Match(left, right);
  if (!matches.has_value()) return std::nullopt;
  return Weigh(*left, *right, *matches);
}

std::vector<JudgedPair> PairPreparation::Judge(const Sample& sample, bool exchanged) const {
  std::vector<std::optional<Sides>> sides;
  sides.reserve(sample.size());
  for (const SampleFrame& frame : sample) sides.push_back(Extract(frame.images, exchanged));
  std::vector<JudgedPair> pairs;
  for (size_t i = 0; i < sample.size(); ++i) {
    std::optional<std::vector<FeatureMatch>> matches = Match(sides[i], sides[i]);
    if (!matches.has_value()) continue;
    JudgedPair pair{sample[i].number, Weigh(*sides[i], *sides[i], *matches), {}, {}, {}};
    std::erase_if(*matches, IsFarApart);
    pair.matches = *std::move(matches);
    if (i > 0 && sample[i - 1].number + 1 == sample[i].number) {
      pair.with_before = Compare(sides[i], sides[i - 1]);
    }
    if (i + 1 < sample.size() && sample[i + 1].number == sample[i].number + 1) {
      pair.with_after = Compare(sides[i], sides[i + 1]);
    }
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

double PairPreparation::MatchShareInTime(const Sample& sample) const {
  std::vector<double> shares;
  for (size_t i = 0; i + 1 < sample.size(); ++i) {
    if (sample[i].number + 1 != sample[i + 1].number) continue;
    const std::optional<Sides> now = Extract(sample[i].images, false);
    const std::optional<Sides> next = Extract(sample[i + 1].images, false);
    if (!now.has_value() || !next.has_value() || !HasEnough(now->left)) continue;
    shares.push_back(static_cast<double>(MatchFeatures(now->left, next->left).size()) /
                     static_cast<double>(now->left.features.keypoints.size()));
  }
  return shares.empty() ? 0 : Median(std::move(shares));
}

}  // namespace corbslam::client_agent
