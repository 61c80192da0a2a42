#include "services/tool/rig/rig_picture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "client_agent/source_checks/feature_matches.h"

namespace corbslam::services {

using client_agent::FeatureMatch;
using client_agent::JudgedPair;
using client_agent::PairPreparation;
using client_agent::Sample;
using client_agent::SampleFrame;

namespace {

constexpr double kAgree_px = 1.25;  // Of the octave at which the corner was found.
constexpr int kRowStep_px = 32;
constexpr size_t kMostDrawn = 150;
const cv::Scalar kRowColour(160, 120, 60);
const cv::Scalar kGoodColour(60, 200, 60);
const cv::Scalar kBadColour(40, 40, 230);

struct Best {
  PairPreparation::Pictures pictures;
  std::vector<FeatureMatch> matches;
};

std::optional<Best> FindBest(const PairPreparation& preparation, const Sample& sample,
                             const std::vector<JudgedPair>& pairs) {
  const auto most = std::max_element(
      pairs.begin(), pairs.end(),
      [](const JudgedPair& a, const JudgedPair& b) { return a.matches.size() < b.matches.size(); });
  if (most == pairs.end()) return std::nullopt;
  const auto frame = std::find_if(sample.begin(), sample.end(), [&](const SampleFrame& candidate) {
    return candidate.number == most->number;
  });
  if (frame == sample.end()) return std::nullopt;
  const auto pictures = preparation.Rectify(frame->images);
  if (!pictures.has_value()) return std::nullopt;
  Best best{*pictures, most->matches};
  for (FeatureMatch& match : best.matches) match.in_b.x() += preparation.right_cx_offset_px();
  return best;
}

cv::Mat Beside(const cv::Mat& left, const cv::Mat& right) {
  cv::Mat both;
  cv::hconcat(left, right, both);
  return both;
}

cv::Mat InColour(const cv::Mat& grey) {
  cv::Mat colour;
  cv::cvtColor(grey, colour, cv::COLOR_GRAY2BGR);
  return colour;
}

void DrawMatches(const Best& best, int right_x_px, cv::Mat& picture) {
  const size_t step = std::max<size_t>(1, best.matches.size() / kMostDrawn);
  for (size_t i = 0; i < best.matches.size(); i += step) {
    const FeatureMatch& match = best.matches[i];
    const bool agree = std::abs(match.in_b.y() - match.in_a.y()) <= kAgree_px * match.scale;
    const cv::Scalar& colour = agree ? kGoodColour : kBadColour;
    const cv::Point2d left(match.in_a.x(), match.in_a.y());
    const cv::Point2d right(match.in_b.x() + right_x_px, match.in_b.y());
    cv::circle(picture, left, 3, colour, 1, cv::LINE_AA);
    cv::circle(picture, right, 3, colour, 1, cv::LINE_AA);
    if (!agree) cv::line(picture, left, right, colour, 1, cv::LINE_AA);
  }
}

// Returns depths as metres where there are any, up to a scale that is the picture's own.
cv::Mat ToFloat(const cv::Mat& depth) {
  cv::Mat result;
  depth.convertTo(result, CV_32F);
  result.setTo(0, result != result);
  if (depth.type() == CV_16UC1) result.setTo(0, depth == 65535);
  return result;
}

}  // namespace

cv::Mat DrawPair(const PairPreparation& preparation, const Sample& sample,
                 const std::vector<JudgedPair>& pairs) {
  const std::optional<Best> best = FindBest(preparation, sample, pairs);
  if (!best.has_value()) return {};
  cv::Mat picture = InColour(Beside(best->pictures.left, best->pictures.right));
  for (int y = kRowStep_px; y < picture.rows; y += kRowStep_px) {
    cv::line(picture, {0, y}, {picture.cols - 1, y}, kRowColour, 1);
  }
  DrawMatches(*best, best->pictures.left.cols, picture);
  return picture;
}

cv::Mat DrawDepth(const Sample& sample) {
  if (sample.empty()) return {};
  const SensorImages& images = sample[sample.size() / 2].images;
  const cv::Mat grey = InColour(images.grey);
  const cv::Mat depth = ToFloat(images.depth);
  if (depth.size() != images.grey.size()) return grey;
  const cv::Mat is_there = depth > 0;
  double near = 0, far = 0;
  cv::minMaxLoc(depth, &near, &far, nullptr, nullptr, is_there);
  if (!(far > near)) return grey;
  // Nearness, so that what is close is told apart best.
  cv::Mat nearness = near / depth;
  nearness.convertTo(nearness, CV_8U, 255);
  cv::Mat coloured;
  cv::applyColorMap(nearness, coloured, cv::COLORMAP_JET);
  cv::Mat over = grey.clone();
  cv::Mat mixed;
  cv::addWeighted(grey, 0.4, coloured, 0.6, 0, mixed);
  mixed.copyTo(over, is_there);
  return Beside(grey, over);
}

}  // namespace corbslam::services
