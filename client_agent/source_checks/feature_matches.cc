#include "client_agent/source_checks/feature_matches.h"

#include <cstdlib>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "slam/features/orb_extractor.h"

namespace corbslam::client_agent {
namespace {

constexpr int kFeatures = 500;
constexpr int kMaxWidth_px = 500;
constexpr int kMinSide_px = 64;  // OrbExtractor needs so much.
// Limits of the Hamming distance in bits and of the ratio. Both are tighter than the tracker's:
// wrong matches would have to be told from a wrong pair.
constexpr int kMaxHamming = 60;
constexpr double kMaxSecondRatio = 0.85;

cv::Mat Reduced(const cv::Mat& grey) {
  if (grey.cols <= kMaxWidth_px || grey.rows < 2 * kMinSide_px) return grey;
  cv::Mat half;
  cv::resize(grey, half, {}, 0.5, 0.5, cv::INTER_AREA);
  return half;
}

struct Best {
  int least = std::numeric_limits<int>::max();
  int second = std::numeric_limits<int>::max();
  size_t id = 0;

  void Offer(int distance, size_t candidate) {
    if (distance < least) {
      second = least;
      least = distance;
      id = candidate;
    } else if (distance < second) {
      second = distance;
    }
  }
  bool IsClear() const {
    return least <= kMaxHamming && least <= kMaxSecondRatio * static_cast<double>(second);
  }
};

}  // namespace

CheckFeatures ExtractCheckFeatures(const cv::Mat& grey) {
  CheckFeatures result;
  if (grey.type() != CV_8UC1 || grey.cols < kMinSide_px || grey.rows < kMinSide_px) return result;
  const cv::Mat reduced = Reduced(grey);
  result.scale = static_cast<double>(grey.cols) / reduced.cols;
  OrbExtractor extractor(OrbOptions{.features = kFeatures});
  ImagePyramid pyramid;
  if (!extractor.Extract(reduced, result.features, pyramid).ok()) result.features = {};
  for (Keypoint& keypoint : result.features.keypoints) {
    keypoint.x_px = static_cast<float>((keypoint.x_px + 0.5) * result.scale - 0.5);
    keypoint.y_px = static_cast<float>((keypoint.y_px + 0.5) * result.scale - 0.5);
  }
  return result;
}

std::vector<FeatureMatch> MatchFeatures(const CheckFeatures& a, const CheckFeatures& b) {
  const Features& in_a = a.features;
  const Features& in_b = b.features;
  std::vector<Best> of_a(in_a.keypoints.size());
  std::vector<Best> of_b(in_b.keypoints.size());
  for (size_t i = 0; i < of_a.size(); ++i) {
    for (size_t k = 0; k < of_b.size(); ++k) {
      if (std::abs(in_a.keypoints[i].octave - in_b.keypoints[k].octave) > 1) continue;
      const int distance = HammingDistance(in_a.descriptors[i], in_b.descriptors[k]);
      of_a[i].Offer(distance, k);
      of_b[k].Offer(distance, i);
    }
  }
  std::vector<FeatureMatch> matches;
  for (size_t i = 0; i < of_a.size(); ++i) {
    if (!of_a[i].IsClear() || of_b[of_a[i].id].id != i) continue;
    const Keypoint& other = in_b.keypoints[of_a[i].id];
    matches.push_back({in_a.keypoints[i].Pixel(), other.Pixel(),
                       a.scale * ScalePyramid::Scale(in_a.keypoints[i].octave)});
  }
  return matches;
}

}  // namespace corbslam::client_agent
