#include "slam/solvers/similarity_ransac.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/solvers/absolute_orientation.h"
#include "slam/solvers/sampling.h"

namespace corbslam {
namespace {

constexpr size_t kSampleSize = 3;
constexpr int kMaxRealignments = 5;

struct Input {
  const Camera& camera_a;
  const Camera& camera_b;
  absl::Span<const SimilarityMatch> matches;
  const SimilarityRansacOptions& options;
};

SimilarityRansacResult Judge(const Input& input, const Similarity3d& b_from_a) {
  SimilarityRansacResult result{b_from_a, std::vector<char>(input.matches.size(), 0), 0};
  for (size_t i = 0; i < input.matches.size(); ++i) {
    const SimilarityErrors errors =
        ReprojectionErrors(input.camera_a, input.camera_b, b_from_a, input.matches[i]);
    // The comparison is written so that NaN is no inlier.
    if (!(errors.in_a <= input.options.max_chi2 && errors.in_b <= input.options.max_chi2)) continue;
    result.is_inlier[i] = 1;
    ++result.inliers;
  }
  return result;
}

template <typename Indices>
absl::StatusOr<Similarity3d> Align(const Input& input, const Indices& indices) {
  std::vector<Eigen::Vector3d> points_a;
  std::vector<Eigen::Vector3d> points_b;
  for (const size_t i : indices) {
    points_a.push_back(input.matches[i].x_in_a);
    points_b.push_back(input.matches[i].x_in_b);
  }
  return AlignPoints(points_a, points_b, input.options.fix_scale);
}

void RealignToInliers(const Input& input, SimilarityRansacResult& best) {
  for (int i = 0; i < kMaxRealignments; ++i) {
    std::vector<size_t> indices;
    for (size_t m = 0; m < best.is_inlier.size(); ++m) {
      if (best.is_inlier[m]) indices.push_back(m);
    }
    const absl::StatusOr<Similarity3d> aligned = Align(input, indices);
    if (!aligned.ok()) return;
    SimilarityRansacResult next = Judge(input, *aligned);
    if (next.inliers <= best.inliers) return;
    best = std::move(next);
  }
}

}  // namespace

absl::StatusOr<SimilarityRansacResult> EstimateSimilarity(const Camera& camera_a,
                                                          const Camera& camera_b,
                                                          absl::Span<const SimilarityMatch> matches,
                                                          const SimilarityRansacOptions& options) {
  if (matches.size() < kSampleSize) {
    return absl::InvalidArgumentError(
        absl::StrCat("similarity: ", matches.size(), " matches, need ", kSampleSize));
  }
  const Input input{camera_a, camera_b, matches, options};
  Sampler sampler(options.seed);
  SimilarityRansacResult best;
  int needed = options.max_iterations;
  for (int i = 0; i < needed; ++i) {
    const auto aligned = Align(input, sampler.Draw<kSampleSize>(matches.size()));
    if (!aligned.ok()) continue;
    SimilarityRansacResult candidate = Judge(input, *aligned);
    if (candidate.inliers <= best.inliers) continue;
    best = std::move(candidate);
    needed = RequiredIterations(static_cast<size_t>(best.inliers), matches.size(), kSampleSize,
                                options.confidence, options.max_iterations);
  }
  if (best.inliers >= static_cast<int>(kSampleSize)) RealignToInliers(input, best);
  if (best.inliers < options.min_inliers || best.is_inlier.empty()) {
    return absl::NotFoundError(absl::StrCat("similarity: ", best.inliers, " of ", matches.size(),
                                            " matches agree, need ", options.min_inliers));
  }
  return best;
}

}  // namespace corbslam
