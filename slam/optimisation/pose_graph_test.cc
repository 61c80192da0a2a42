#include "slam/optimisation/pose_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "slam/geometry/lie.h"
#include "slam/optimisation/graduated_non_convexity.h"
#include "slam/optimisation/relative_pose_cost.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam {
namespace {

using ::testing::HasSubstr;
constexpr LocalMapId kMap{0x77};

KeyframeId Id(int index) { return {kMap, static_cast<uint32_t>(index)}; }

// Makes a round trip of `count` cameras.
std::map<KeyframeId, Similarity3d> Circle(int count) {
  std::map<KeyframeId, Similarity3d> poses;
  for (int i = 0; i < count; ++i) {
    const double angle_rad = 2 * M_PI * i / count;
    const Similarity3d map_from_camera{
        1, ExpSO3({0, 0, angle_rad}), {10 * std::cos(angle_rad), 10 * std::sin(angle_rad), 0}};
    poses[Id(i)] = map_from_camera.Inverse();
  }
  return poses;
}

std::vector<PoseGraphEdge> RingEdges(const std::map<KeyframeId, Similarity3d>& poses) {
  std::vector<PoseGraphEdge> edges;
  const int count = static_cast<int>(poses.size());
  for (int i = 0; i < count; ++i) {
    const KeyframeId next = Id((i + 1) % count);
    edges.push_back({Id(i), next, poses.at(next) * poses.at(Id(i)).Inverse()});
  }
  return edges;
}

double Distance(const Similarity3d& a, const Similarity3d& b) {
  return LogSim3(a * b.Inverse()).norm();
}

template <int kTangent>
void CheckJacobians() {
  const Vector7d base = (Vector7d() << 1, -2, 0.5, 0.3, -0.4, 0.7, 0.2).finished();
  Vector7d other = (Vector7d() << 0.5, 1, -0.3, -0.2, 0.6, 0.1, -0.3).finished();
  Vector7d measured = (Vector7d() << 0.2, 0.4, 0.1, 0.5, 0.1, -0.6, 0.1).finished();
  if (kTangent == 6) other[6] = measured[6] = 0;
  Vector7d first = base;
  if (kTangent == 6) first[6] = 0;
  const SimilarityBlock blocks[2] = {ToBlock(ExpSim3(first)), ToBlock(ExpSim3(other))};
  Matrix7d R = Matrix7d::Identity() * 1.5;
  R(0, 3) = 0.4;
  R(2, 5) = -0.7;
  R(4, 6) = 0.3;
  const RelativePoseCost<kTangent> cost(ExpSim3(measured), R);
  const LeftPerturbation<kTangent> manifold;
  using Jacobian = Eigen::Matrix<double, kTangent, 8, Eigen::RowMajor>;
  using Residual = Eigen::Matrix<double, kTangent, 1>;
  Jacobian J[2];
  double* jacobians[2] = {J[0].data(), J[1].data()};
  const double* parameters[2] = {blocks[0].data(), blocks[1].data()};
  Residual residual;
  ASSERT_TRUE(cost.Evaluate(parameters, residual.data(), jacobians));
  for (int block = 0; block < 2; ++block) {
    for (int i = 0; i < kTangent; ++i) {
      Residual sides[2];
      for (int side = 0; side < 2; ++side) {
        const Residual step = (side == 0 ? 1e-6 : -1e-6) * Residual::Unit(i);
        SimilarityBlock moved{};
        manifold.Plus(blocks[block].data(), step.data(), moved.data());
        const double* at[2] = {parameters[0], parameters[1]};
        at[block] = moved.data();
        cost.Evaluate(at, sides[side].data(), nullptr);
      }
      EXPECT_LT(((sides[0] - sides[1]) / 2e-6 - J[block].col(i)).norm(), 1e-6) << block << " " << i;
    }
  }
}

TEST(RelativePoseCostTest, JacobiansAgreeWithNumericDifferences) {
  CheckJacobians<6>();
  CheckJacobians<7>();
}

TEST(PoseGraphTest, UndoesDriftWithoutScale) {
  const auto truth = Circle(20);
  const auto edges = RingEdges(truth);
  auto drifted = truth;
  for (int i = 1; i < 20; ++i) {
    drifted[Id(i)] = ExpSim3((Vector7d() << 0.02 * i, 0.01 * i, 0, 0, 0, 0.005 * i, 0).finished()) *
                     truth.at(Id(i));
  }
  const auto result = OptimisePoseGraph(drifted, edges, {Id(0)}, {});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_LT(result->final_cost, 1e-8);
  for (const auto& [id, pose] : truth) {
    EXPECT_LT(Distance(result->camera_from_map.at(id), pose), 1e-4) << ToString(id);
    EXPECT_NEAR(result->camera_from_map.at(id).scale, 1, 1e-12);
  }
}

TEST(PoseGraphTest, UndoesDriftOfScale) {
  const auto truth = Circle(20);
  auto drifted = truth;
  for (int i = 1; i < 20; ++i) {
    drifted[Id(i)] =
        ExpSim3((Vector7d() << 0, 0, 0, 0, 0, 0.003 * i, 0.02 * i).finished()) * truth.at(Id(i));
  }
  PoseGraphOptions options;
  options.fix_scale = false;
  const auto result = OptimisePoseGraph(drifted, RingEdges(truth), {Id(0)}, options);
  ASSERT_TRUE(result.ok()) << result.status();
  for (const auto& [id, pose] : truth) {
    EXPECT_LT(Distance(result->camera_from_map.at(id), pose), 1e-4) << ToString(id);
  }
}

// Metres that a camera measures are not estimated anew beside others that have none.
TEST(PoseGraphTest, SomeKeepTheirScaleBesideOthers) {
  const std::map<KeyframeId, Similarity3d> truth = Circle(8);
  std::vector<PoseGraphEdge> edges = RingEdges(truth);
  edges[5].b_from_a.scale = 1.03;
  PoseGraphOptions options;
  options.fix_scale = false;
  options.keep_scale = {Id(0), Id(1), Id(2), Id(3)};
  const auto result = OptimisePoseGraph(truth, edges, {Id(0)}, options);
  ASSERT_TRUE(result.ok()) << result.status();
  for (int i = 0; i < 4; ++i) EXPECT_EQ(result->camera_from_map.at(Id(i)).scale, 1) << i;
  EXPECT_GT(std::abs(result->camera_from_map.at(Id(6)).scale - 1), 1e-4);
  EXPECT_LT(result->final_cost, result->initial_cost);
}

TEST(PoseGraphTest, AWrongRobustEdgeStandsOutAndLeavesThePosesNearTheTruth) {
  const auto truth = Circle(20);
  auto edges = RingEdges(truth);
  for (int i = 0; i < 20; ++i) {
    const KeyframeId next = Id((i + 3) % 20);
    edges.push_back({Id(i), next, truth.at(next) * truth.at(Id(i)).Inverse()});
  }
  for (PoseGraphEdge& edge : edges) edge.weight = 1e4;
  PoseGraphEdge wrong{Id(3), Id(12), truth.at(Id(12)) * truth.at(Id(3)).Inverse(), 1e4, true};
  wrong.b_from_a.translation.x() += 5;
  edges.push_back(wrong);
  const auto result = OptimisePoseGraph(truth, edges, {Id(0)}, {});
  ASSERT_TRUE(result.ok());
  for (size_t i = 0; i + 1 < edges.size(); ++i) {
    EXPECT_LT(result->edge_chi2[i], 1e-6 * result->edge_chi2.back()) << i;
  }
  for (const auto& [id, pose] : truth) {
    EXPECT_LT(Distance(result->camera_from_map.at(id), pose), 0.1) << ToString(id);
  }
}

// The start is where a wrong edge and drift have led, among true robust edges.
TEST(PoseGraphTest, TwoWrongEdgesAmongTrueOnesLeaveThePosesNearTheTruth) {
  const auto truth = Circle(20);
  auto edges = RingEdges(truth);
  for (PoseGraphEdge& edge : edges) edge.weight = 1e4;
  for (const auto& [a, b] : {std::pair(2, 11), {5, 15}, {8, 17}, {3, 12}, {6, 16}}) {
    edges.push_back({Id(a), Id(b), truth.at(Id(b)) * truth.at(Id(a)).Inverse(), 1e4, true});
  }
  edges[edges.size() - 1].b_from_a.translation.y() += 8;
  edges[edges.size() - 2].b_from_a.translation.x() -= 3;
  auto drifted = truth;
  for (int i = 1; i < 20; ++i) {
    drifted[Id(i)] = ExpSim3((Vector7d() << 0.03 * i, -0.02 * i, 0, 0, 0, 0.01 * i, 0).finished()) *
                     truth.at(Id(i));
  }
  const auto result = OptimisePoseGraph(drifted, edges, {Id(0)}, {});
  ASSERT_TRUE(result.ok());
  for (const auto& [id, pose] : truth) {
    EXPECT_LT(Distance(result->camera_from_map.at(id), pose), 0.1) << ToString(id);
  }
  EXPECT_LT(result->final_cost, result->initial_cost);
}

TEST(PoseGraphTest, ATrueRobustLoopStillUndoesDrift) {
  const auto truth = Circle(20);
  auto drifted = truth;
  for (int i = 1; i < 20; ++i) {
    drifted[Id(i)] = ExpSim3((Vector7d() << 0.1 * i, 0.05 * i, 0, 0, 0, 0.01 * i, 0).finished()) *
                     truth.at(Id(i));
  }
  // Odometry says what drifted; the last edge closes the ring.
  auto edges = RingEdges(drifted);
  edges.back().b_from_a = truth.at(Id(0)) * truth.at(Id(19)).Inverse();
  edges.back().robust = true;
  const auto result = OptimisePoseGraph(drifted, edges, {Id(0)}, {});
  ASSERT_TRUE(result.ok());
  const double before = Distance(drifted.at(Id(19)), truth.at(Id(19)));
  EXPECT_GT(before, 1.5);
  EXPECT_LT(Distance(result->camera_from_map.at(Id(19)), truth.at(Id(19))), 0.1 * before);
}

// Returns how far the end of a straight way of 100 m goes, which leads away from a loop around a
// circle, when the loop is closed by 0.3 m.
double EndOfTheWayGoes_m(double depth) {
  auto poses = Circle(40);
  std::vector<PoseGraphEdge> edges = RingEdges(poses);
  edges.back().b_from_a.translation.x() += 0.3;
  edges.back().weight = 10;
  Similarity3d map_from_camera = poses.at(Id(30)).Inverse();
  for (int i = 0; i < 100; ++i) {
    const KeyframeId last = i == 0 ? Id(30) : Id(39 + i);
    map_from_camera.translation.x() -= 1;
    poses[Id(40 + i)] = map_from_camera.Inverse();
    edges.push_back({last, Id(40 + i), map_from_camera.Inverse() * poses.at(last).Inverse()});
  }
  for (PoseGraphEdge& edge : edges) edge.root_information = RootInformationAtDepth(depth);
  const auto result = OptimisePoseGraph(poses, edges, {Id(0)}, {});
  EXPECT_TRUE(result.ok()) << result.status();
  return (result->camera_from_map.at(Id(139)).Inverse().translation - map_from_camera.translation)
      .norm();
}

TEST(PoseGraphTest, ATurnCountsByTheDepthOfWhatIsSeen) {
  EXPECT_GT(EndOfTheWayGoes_m(1), 0.9);
  EXPECT_LT(EndOfTheWayGoes_m(20), 0.3);
}

TEST(PoseGraphTest, RootsOfInformation) {
  Matrix7d A = Matrix7d::Identity();
  A(0, 3) = 0.5;
  A(4, 6) = -0.3;
  const Matrix7d covariance = 0.1 * A * A.transpose();
  const Matrix7d R = RootInformation(covariance);
  EXPECT_LT((R.transpose() * R * covariance - Matrix7d::Identity()).norm(), 1e-9);
  EXPECT_TRUE(R.isUpperTriangular());
}

// Half of the loops are wrong, and four of them agree with each other.
TEST(PoseGraphTest, AsManyWrongRobustEdgesAsTrueOnesLeaveThePosesNearTheTruth) {
  const auto truth = Circle(40);
  auto drifted = truth;
  for (int i = 1; i < 40; ++i) {
    drifted[Id(i)] =
        ExpSim3((Vector7d() << 0.02 * i, -0.01 * i, 0, 0, 0, 0.002 * i, 0).finished()) *
        truth.at(Id(i));
  }
  auto edges = RingEdges(drifted);
  edges.pop_back();
  for (PoseGraphEdge& edge : edges) edge.weight = 1e3;
  const auto add = [&](int a, int b, const Similarity3d& map_from_map) {
    edges.push_back(
        {Id(a), Id(b), truth.at(Id(b)) * map_from_map * truth.at(Id(a)).Inverse(), 1e3, true});
  };
  for (int i = 0; i < 6; ++i) add(i, 39 - i, Similarity3d::Identity());
  const Similarity3d alias = ExpSim3((Vector7d() << 8, 3, 0, 0, 0, 1, 0).finished());
  for (int i = 0; i < 4; ++i) add(2 + i, 20 + i, alias);
  add(10, 30, ExpSim3((Vector7d() << -5, 4, 1, 0, 0, 0, 0).finished()));
  add(12, 28, ExpSim3((Vector7d() << 3, 9, 0, 0, 0.3, 0, 0).finished()));
  const auto result = OptimisePoseGraph(drifted, edges, {Id(0)}, {});
  ASSERT_TRUE(result.ok());
  for (size_t i = 39; i < edges.size(); ++i) {
    EXPECT_EQ(result->edge_chi2[i] > 12.6, i >= 39 + 6) << i;
  }
  EXPECT_LT(Distance(result->camera_from_map.at(Id(39)), truth.at(Id(39))),
            0.1 * Distance(drifted.at(Id(39)), truth.at(Id(39))));
}

TEST(GraduatedTruncationTest, SharpensFromTheWorstErrorOnToACut) {
  constexpr double kMax = 12.6;
  GraduatedTruncation truncation(kMax, 1000);
  // All have a say at first (remark 5 of Yang et al.).
  EXPECT_EQ(truncation.Weight(0), 1);
  EXPECT_GT(truncation.Weight(1000), 0);
  for (int i = 0; i < 40; ++i) {
    // The weight falls from 1 to 0, and without a jump while it is not sharp.
    double last = 1;
    for (double s = 0.01; s < 3000; s *= 1.01) {
      const double weight = truncation.Weight(s);
      EXPECT_LE(weight, last) << i << " " << s;
      EXPECT_GE(weight, 0);
      EXPECT_LT(last - weight, i < 10 ? 0.1 : 1.1) << i << " " << s;
      last = weight;
    }
    EXPECT_EQ(last, 0);
    truncation.Sharpen();
  }
  EXPECT_EQ(truncation.Weight(1.01 * kMax), 0);
  EXPECT_EQ(truncation.Weight(0.99 * kMax), 1);
}

TEST(PoseGraphTest, RefusesBadGraphsAndNamesTheId) {
  const auto truth = Circle(6);
  const auto edges = RingEdges(truth);
  auto bad = edges;
  bad[2].b = Id(99);
  absl::Status status = OptimisePoseGraph(truth, bad, {Id(0)}, {}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr(ToString(Id(99))));
  EXPECT_EQ(OptimisePoseGraph(truth, edges, {}, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(OptimisePoseGraph(truth, edges, {Id(50)}, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
  bad = edges;
  bad[1].b_from_a.translation.x() = NAN;
  EXPECT_EQ(OptimisePoseGraph(truth, bad, {Id(0)}, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_TRUE(OptimisePoseGraph(truth, {}, {}, {}).ok());
}

TEST(EssentialGraphTest, JoinsTheTreeAndIsAtRestAtThePresentPoses) {
  testing::SyntheticScene scene = testing::MakeSyntheticScene({});
  const KeyframeId first = scene.map.keyframes().begin()->first;
  const KeyframeId last = scene.map.keyframes().rbegin()->first;
  const size_t before = EssentialGraphEdges(scene.map, 100000).size();
  EXPECT_EQ(before, scene.map.keyframes().size() - 1);
  scene.map.AddLoopEdge(first, last);
  const auto edges = EssentialGraphEdges(scene.map, 100000);
  EXPECT_EQ(edges.size(), before + 1);
  std::map<KeyframeId, Similarity3d> poses;
  for (const auto& [id, keyframe] : scene.map.keyframes()) {
    poses[id] = Similarity3d::FromRigid(keyframe.camera_from_map);
  }
  const auto result = OptimisePoseGraph(poses, edges, {first}, {});
  ASSERT_TRUE(result.ok());
  EXPECT_LT(result->initial_cost, 1e-20);
}

TEST(MovePointsTest, PointsKeepTheirPlaceInTheirReferencesView) {
  const testing::SyntheticScene scene = testing::MakeSyntheticScene({});
  const Similarity3d shift = ExpSim3((Vector7d() << 1, 2, 3, 0.1, 0.2, 0.3, 0.4).finished());
  std::map<KeyframeId, Similarity3d> corrected;
  for (const auto& [id, keyframe] : scene.map.keyframes()) {
    corrected[id] = Similarity3d::FromRigid(keyframe.camera_from_map) * shift.Inverse();
  }
  const auto updates = MovePointsWithReferences(scene.map, corrected);
  ASSERT_EQ(updates.size(), scene.map.points().size());
  for (const PositionUpdate& update : updates) {
    const Eigen::Vector3d expected = shift * scene.map.FindPoint(update.id)->position_in_map;
    EXPECT_LT((update.position_in_map - expected).norm(), 1e-9);
  }
  EXPECT_TRUE(MovePointsWithReferences(scene.map, {}).empty());
}

}  // namespace
}  // namespace corbslam
