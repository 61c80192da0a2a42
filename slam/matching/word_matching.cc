#include "slam/matching/word_matching.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "slam/matching/orientation_histogram.h"

namespace corbslam {
namespace {

constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
constexpr int kFar = 257;

// A claim is the best candidate so far for a keypoint of b.
struct Claim {
  uint32_t keypoint_a = kNone;
  int distance = kFar;
};

std::vector<char> UsableKeypoints(const Keyframe& keyframe, bool need_points) {
  const size_t count = std::min(keyframe.keypoints().size(), keyframe.descriptors().size());
  std::vector<char> usable(count, 1);
  if (!need_points) return usable;
  for (size_t i = 0; i < count; ++i) {
    usable[i] = i < keyframe.points.size() && keyframe.points[i].IsValid();
  }
  return usable;
}

std::vector<uint32_t> Usable(const std::vector<uint32_t>& features,
                             const std::vector<char>& is_usable) {
  std::vector<uint32_t> kept;
  kept.reserve(features.size());
  for (const uint32_t feature : features) {
    if (feature < is_usable.size() && is_usable[feature]) kept.push_back(feature);
  }
  return kept;
}

// Lets each of `features_a` claim its best of `features_b`; the nearest claim of a keypoint wins.
void MatchWithinNode(const Keyframe& a, const std::vector<uint32_t>& features_a, const Keyframe& b,
                     const std::vector<uint32_t>& features_b, const WordMatchingOptions& options,
                     std::vector<Claim>& claims) {
  for (const uint32_t i : features_a) {
    int best = kFar;
    int second = kFar;
    uint32_t best_j = kNone;
    const Descriptor& descriptor = a.descriptors()[i];
    for (const uint32_t j : features_b) {
      const int distance = HammingDistance(descriptor, b.descriptors()[j]);
      if (distance < best) {
        second = best;
        best = distance;
        best_j = j;
      } else if (distance < second) {
        second = distance;
      }
    }
    if (best > options.max_distance || best >= options.max_ratio * second) continue;
    if (best < claims[best_j].distance) claims[best_j] = {i, best};
  }
}

bool HasNodes(const Keyframe& keyframe) {
  return keyframe.words != nullptr && !keyframe.words->direct_index.empty();
}

void MatchAllNodes(const Keyframe& a, const Keyframe& b, const WordMatchingOptions& options,
                   std::vector<Claim>& claims) {
  const std::vector<char> usable_a = UsableKeypoints(a, options.need_points_a);
  const std::vector<char> usable_b = UsableKeypoints(b, options.need_points_b);
  if (!HasNodes(a) || !HasNodes(b)) {
    std::vector<uint32_t> all_a(usable_a.size());
    std::vector<uint32_t> all_b(usable_b.size());
    std::iota(all_a.begin(), all_a.end(), 0u);
    std::iota(all_b.begin(), all_b.end(), 0u);
    MatchWithinNode(a, Usable(all_a, usable_a), b, Usable(all_b, usable_b), options, claims);
    return;
  }
  auto node_a = a.words->direct_index.begin();
  auto node_b = b.words->direct_index.begin();
  while (node_a != a.words->direct_index.end() && node_b != b.words->direct_index.end()) {
    if (node_a->node < node_b->node) {
      ++node_a;
    } else if (node_b->node < node_a->node) {
      ++node_b;
    } else {
      MatchWithinNode(a, Usable(node_a->features, usable_a), b, Usable(node_b->features, usable_b),
                      options, claims);
      ++node_a;
      ++node_b;
    }
  }
}

// A place seen twice is turned by the same angle everywhere.
void DropOddOrientations(const Keyframe& a, const Keyframe& b, std::vector<Claim>& claims) {
  OrientationHistogram histogram;
  for (size_t j = 0; j < claims.size(); ++j) {
    if (claims[j].keypoint_a == kNone) continue;
    histogram.Add(a.keypoints()[claims[j].keypoint_a].angle_rad, b.keypoints()[j].angle_rad);
  }
  histogram.Select();
  for (size_t j = 0; j < claims.size(); ++j) {
    if (claims[j].keypoint_a == kNone) continue;
    if (!histogram.IsKept(a.keypoints()[claims[j].keypoint_a].angle_rad,
                          b.keypoints()[j].angle_rad)) {
      claims[j] = {};
    }
  }
}

}  // namespace

std::vector<std::pair<uint32_t, uint32_t>> MatchByWords(const Keyframe& a, const Keyframe& b,
                                                        const WordMatchingOptions& options) {
  std::vector<Claim> claims(std::min(b.keypoints().size(), b.descriptors().size()));
  MatchAllNodes(a, b, options, claims);
  if (options.check_orientation) DropOddOrientations(a, b, claims);
  std::vector<std::pair<uint32_t, uint32_t>> matches;
  for (size_t j = 0; j < claims.size(); ++j) {
    if (claims[j].keypoint_a == kNone) continue;
    matches.emplace_back(claims[j].keypoint_a, static_cast<uint32_t>(j));
  }
  std::sort(matches.begin(), matches.end());
  return matches;
}

}  // namespace corbslam
