// Makes pose graphs of several robots with true and wrong overlaps, and their truth.
#ifndef CORBSLAM_TESTS_BENCH_ALIASED_GRAPH_H_
#define CORBSLAM_TESTS_BENCH_ALIASED_GRAPH_H_

#include <cstdint>
#include <map>
#include <vector>

#include "absl/container/btree_set.h"
#include "slam/optimisation/pose_graph.h"

namespace corbslam::tests {

struct AliasedGraphOptions {
  int maps = 2;
  int true_overlaps = 20;
  double wrong_share = 0;  // Share of all overlaps.
  // How many neighbouring pairs of keyframes make the same mistake, as happens where two streets
  // look alike; 1: each errs in its own way.
  int cluster = 1;
  uint64_t seed = 1;
};

struct AliasedGraph {
  // camera_from_map of the first local map. Odometry is chained, and the other maps are placed by
  // the overlaps that most others agree with, as fusing does (AlignByConsensus).
  std::map<KeyframeId, Similarity3d> initial;
  std::map<KeyframeId, Rigid3d> true_camera_from_world;
  // Edges of odometry and of overlaps; both are weighted by the inverse variance of their
  // translation's noise.
  std::vector<PoseGraphEdge> odometry;
  std::vector<PoseGraphEdge> overlaps;
  std::vector<bool> is_wrong;  // One entry an overlap.
  absl::btree_set<KeyframeId> fixed;
  double odometry_sigma_rad = 0;  // Standard deviation of a step, with its systematic part.
};

// The robots share a ring of 30 m radius, each a piece of it, and meet the next one at its end (and
// the last one the first). Odometry drifts by noise and a turn that each robot always makes; wrong
// overlaps say, of keyframes more than 10 m apart, that they are within 3 m of each other.
AliasedGraph MakeAliasedGraph(const AliasedGraphOptions& options);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_BENCH_ALIASED_GRAPH_H_
