// On these graphs graduated non-convexity alone ended beside the least truncated cost: they have
// wrong overlaps in clusters of four that agree with each other.
#include "tests/bench/aliased_graph.h"

#include <gtest/gtest.h>

#include <map>

#include "absl/strings/str_cat.h"
#include "slam/verification/testing/synthetic_world.h"
#include "tests/bench/robust_solvers.h"

namespace corbslam::tests {
namespace {

struct Case {
  int maps = 2;
  int wrong_percent = 0;
  uint64_t seed = 1;
};

class ClustersTest : public ::testing::TestWithParam<Case> {};

double Ate_m(const PoseGraphResult& result, const AliasedGraph& graph) {
  std::map<KeyframeId, Rigid3d> estimate;
  for (const auto& [id, pose] : result.camera_from_map) estimate[id] = pose.ToRigid();
  return testing::AteRmse_m(estimate, graph.true_camera_from_world);
}

TEST_P(ClustersTest, TrueOverlapsWin) {
  AliasedGraphOptions options;
  options.maps = GetParam().maps;
  options.wrong_share = GetParam().wrong_percent / 100.0;
  options.cluster = 4;
  options.seed = GetParam().seed;
  const AliasedGraph graph = MakeAliasedGraph(options);
  std::vector<PoseGraphEdge> edges = graph.odometry;
  edges.insert(edges.end(), graph.overlaps.begin(), graph.overlaps.end());
  const auto solved = OptimisePoseGraph(graph.initial, edges, graph.fixed, {});
  const auto clean = SolveClean(graph);
  ASSERT_TRUE(solved.ok() && clean.ok()) << solved.status() << clean.status();
  EXPECT_LE(Ate_m(*solved, graph), 1.1 * Ate_m(*clean, graph));
}

INSTANTIATE_TEST_SUITE_P(FoundWrong, ClustersTest,
                         ::testing::Values(Case{2, 20, 5}, Case{3, 30, 4}, Case{4, 10, 4},
                                           Case{4, 20, 9}, Case{4, 30, 5}, Case{4, 30, 9}),
                         [](const auto& info) {
                           return absl::StrCat(info.param.maps, "_maps_", info.param.wrong_percent,
                                               "_percent_seed_", info.param.seed);
                         });

}  // namespace
}  // namespace corbslam::tests
