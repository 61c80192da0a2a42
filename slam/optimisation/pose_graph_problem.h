// A pose graph as a least-squares problem that is solved many times, with other weights of its
// robust edges each time.
#ifndef CORBSLAM_SLAM_OPTIMISATION_POSE_GRAPH_PROBLEM_H_
#define CORBSLAM_SLAM_OPTIMISATION_POSE_GRAPH_PROBLEM_H_

#include <ceres/ceres.h>

#include <cstddef>
#include <map>
#include <vector>

#include "absl/container/btree_set.h"
#include "absl/status/status.h"
#include "absl/types/span.h"
#include "slam/optimisation/graduated_non_convexity.h"
#include "slam/optimisation/pose_graph.h"
#include "slam/optimisation/similarity_manifold.h"

namespace corbslam {

// Not thread-safe.
class PoseGraphProblem {
 public:
  using Blocks = std::map<KeyframeId, SimilarityBlock>;

  // `edges`, whose ends must be among the poses, must outlive it. All robust edges have weight 1.
  PoseGraphProblem(const std::map<KeyframeId, Similarity3d>& initial,
                   absl::Span<const PoseGraphEdge> edges, const absl::btree_set<KeyframeId>& fixed,
                   const PoseGraphOptions& options);
  PoseGraphProblem(const PoseGraphProblem&) = delete;
  PoseGraphProblem& operator=(const PoseGraphProblem&) = delete;

  // Solves least squares from the present poses on. INTERNAL where the solver fails.
  absl::Status Solve();

  absl::Span<const PoseGraphEdge> edges() const { return edges_; }
  // Indices of the robust edges.
  const std::vector<size_t>& robust() const { return robust_; }
  // Multiplies the squared residual of a robust edge.
  double weight(size_t edge) const { return weights_[edge].value(); }
  // Returns true if it is another weight than before.
  bool SetWeight(size_t edge, double weight);

  const Blocks& poses() const { return blocks_; }
  void SetPoses(const Blocks& poses);

  // Returns edge.weight * |residual|^2 of each edge at the present poses.
  std::vector<double> EdgeChi2() const;
  // A robust edge counts no more from this chi2 on.
  double max_chi2() const;
  // Returns 0.5 * the sum of `chi2`, to which a robust edge adds at most max_chi2.
  double TruncatedCost(const std::vector<double>& chi2) const;

  int iterations() const { return iterations_; }

 private:
  template <int kTangent>
  void AddEdges(const absl::btree_set<KeyframeId>& fixed);

  const absl::Span<const PoseGraphEdge> edges_;
  const PoseGraphOptions options_;
  std::vector<size_t> robust_;
  Blocks blocks_;
  std::vector<AdjustableWeight> weights_;
  ceres::Problem problem_;
  int iterations_ = 0;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_POSE_GRAPH_PROBLEM_H_
