#include "client_agent/source_checks/input_watch.h"

#include <cmath>

#include "absl/strings/str_format.h"

namespace corbslam::client_agent {
namespace {

// docs/sources_checks.md says what these limits were derived from.
constexpr size_t kFrames = 50;
constexpr size_t kFewestFeatures = 100;  // A frame with fewer is dark or bare: it tells nothing.
// Shares of the features. A start in which hardly any has depth is a source that is none; later the
// robot may stand in front of a bare wall, whose few features are noise.
constexpr double kLeastStereoAtStart = 0.12;
constexpr double kLeastStereo = 0.05;
constexpr double kLeastDepthAtStart = 0.03;
constexpr double kLeastDepth = 0.02;
constexpr double kMostAtInfinity = 0.95;
constexpr double kNotableRows_px = 0.1;
constexpr float kInfinity_px = 0.5F;  // Noise may make a disparity below it.

double Share(size_t part, size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

InputWatch::InputWatch(const SensorCalibration& calibration) : kind_(KindOf(calibration)) {}

std::optional<SourceFinding> InputWatch::Add(const Features& features) {
  if (kind_ == SensorKind::kMonocular || features.keypoints.size() < kFewestFeatures)
    return std::nullopt;
  Count count;
  count.features = features.keypoints.size();
  for (const Keypoint& keypoint : features.keypoints) {
    count.with_depth += keypoint.HasDepth() ? 1 : 0;
    count.at_infinity += keypoint.HasDepth() && keypoint.disparity_px < kInfinity_px ? 1 : 0;
  }
  window_.push_back(count);
  sum_.features += count.features;
  sum_.with_depth += count.with_depth;
  sum_.at_infinity += count.at_infinity;
  if (window_.size() > kFrames) {
    sum_.features -= window_.front().features;
    sum_.with_depth -= window_.front().with_depth;
    sum_.at_infinity -= window_.front().at_infinity;
    window_.pop_front();
  }
  if (window_.size() < kFrames) return std::nullopt;
  std::optional<SourceFinding> finding = Judge();
  is_start_ = false;
  const bool is_news = finding.has_value() && !told_;
  told_ = finding.has_value();
  return is_news ? finding : std::nullopt;
}

std::optional<SourceFinding> InputWatch::AddRows(double correction_px) {
  if (std::abs(correction_px - told_rows_px_) < kNotableRows_px) return std::nullopt;
  told_rows_px_ = correction_px;
  return SourceFinding{
      FindingLevel::kWarning, "pair-rows-put-right",
      absl::StrFormat(
          "the right pictures lie %.2f px %s than this rig's calibration says, by what "
          "left and right ones show: they are moved by as much. The calibration is no longer this "
          "rig's; calibrate it when you can",
          std::abs(correction_px), correction_px > 0 ? "lower" : "higher")};
}

std::optional<SourceFinding> InputWatch::Judge() const {
  const bool is_stereo = kind_ == SensorKind::kStereo;
  const double with_depth = Share(sum_.with_depth, sum_.features);
  // A finding is over when it would not be told at the start either.
  const bool strict = is_start_ || told_;
  const double least = is_stereo ? (strict ? kLeastStereoAtStart : kLeastStereo)
                                 : (strict ? kLeastDepthAtStart : kLeastDepth);
  if (with_depth < least) {
    return SourceFinding{
        FindingLevel::kWarning, is_stereo ? "stereo-points-few" : "depth-points-few",
        absl::StrFormat("%s %.1f %% of the features in the last %d frames: less than %.0f %% is no "
                        "basis for a map. %s",
                        is_stereo ? "stereo points are" : "depth was found for", 100 * with_depth,
                        kFrames, 100 * least,
                        is_stereo ? "Are left and right pictures of one time and rectified, and "
                                    "is neither covered?"
                                  : "Is the scene out of the sensor's range, or the depth "
                                    "camera covered?")};
  }
  const double at_infinity = Share(sum_.at_infinity, sum_.with_depth);
  if (!is_stereo || at_infinity <= kMostAtInfinity) return std::nullopt;
  return SourceFinding{
      FindingLevel::kWarning, "stereo-points-without-parallax",
      absl::StrFormat("%.0f %% of the stereo points of the last %d frames have a disparity below "
                      "%.1f px: they have no depth. Is the right picture a copy of the left one, "
                      "or all that is seen too far away for this baseline?",
                      100 * at_infinity, kFrames, static_cast<double>(kInfinity_px))};
}

}  // namespace corbslam::client_agent
