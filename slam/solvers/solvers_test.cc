#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "slam/geometry/lie.h"
#include "slam/optimisation/testing/synthetic_scene.h"
#include "slam/solvers/absolute_orientation.h"
#include "slam/solvers/pnp_ransac.h"
#include "slam/solvers/similarity_ransac.h"
#include "slam/solvers/triangulation.h"

namespace corbslam {
namespace {

const Similarity3d kTruth =
    ExpSim3((Vector7d() << 0.4, -0.2, 0.3, 0.05, -0.1, 0.08, 0.2).finished());

double Uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

std::vector<Eigen::Vector3d> RandomPoints(int count, double near_m = 4, double far_m = 9) {
  std::mt19937_64 random(5);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const double z = Uniform(random, near_m, far_m);
    const double x = Uniform(random, -0.5, 0.5) * z;
    points.emplace_back(x, Uniform(random, -0.3, 0.3) * z, z);
  }
  return points;
}

std::vector<Eigen::Vector3d> Transform(const Similarity3d& b_from_a,
                                       const std::vector<Eigen::Vector3d>& points) {
  std::vector<Eigen::Vector3d> moved;
  for (const Eigen::Vector3d& x : points) moved.push_back(b_from_a * x);
  return moved;
}

TEST(AlignPointsTest, FindsSimilaritiesAndTheirInverses) {
  const auto points = RandomPoints(10);
  for (const Similarity3d& truth : {kTruth, kTruth.Inverse(), Similarity3d::Identity()}) {
    const auto found = AlignPoints(points, Transform(truth, points), false);
    ASSERT_TRUE(found.ok()) << found.status();
    EXPECT_LT(LogSim3(*found * truth.Inverse()).norm(), 1e-9);
  }
  const auto rigid = AlignPoints(points, Transform(kTruth, points), true);
  ASSERT_TRUE(rigid.ok());
  EXPECT_EQ(rigid->scale, 1);
}

TEST(AlignPointsTest, RefusesDegenerateInput) {
  auto points = RandomPoints(5);
  EXPECT_FALSE(AlignPoints({points.data(), 2}, {points.data(), 2}, true).ok());
  EXPECT_FALSE(AlignPoints({points.data(), 3}, {points.data(), 4}, true).ok());
  for (size_t i = 0; i < points.size(); ++i) {
    points[i] = Eigen::Vector3d(1, 2, 3) * static_cast<double>(i);
  }
  EXPECT_EQ(AlignPoints(points, points, true).status().code(), absl::StatusCode::kInvalidArgument);
  points[1].x() = NAN;
  EXPECT_EQ(AlignPoints(points, points, true).status().code(), absl::StatusCode::kInvalidArgument);
}

std::vector<SimilarityMatch> Matches(int count, int wrong) {
  const Camera camera = testing::SyntheticCamera();
  const auto points = RandomPoints(count);
  std::vector<SimilarityMatch> matches;
  for (const Eigen::Vector3d& a : points) {
    const Eigen::Vector3d b = kTruth * a;
    matches.push_back({a, b, Project(camera, a), Project(camera, b), 1, 1});
  }
  for (int i = 0; i < wrong; ++i) {
    SimilarityMatch& match = matches[static_cast<size_t>(i)];
    const SimilarityMatch& other = matches[static_cast<size_t>(count - 1 - i)];
    match.x_in_b = other.x_in_b;
    match.pixel_in_b = other.pixel_in_b;
  }
  return matches;
}

TEST(EstimateSimilarityTest, SurvivesHalfWrongMatchesAndRepeatsItself) {
  const Camera camera = testing::SyntheticCamera();
  const auto matches = Matches(80, 40);
  SimilarityRansacOptions options;
  options.fix_scale = false;
  const auto found = EstimateSimilarity(camera, camera, matches, options);
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_LT(LogSim3(found->b_from_a * kTruth.Inverse()).norm(), 1e-6);
  EXPECT_EQ(found->inliers, 40);
  EXPECT_FALSE(found->is_inlier[0]);
  const auto again = EstimateSimilarity(camera, camera, matches, options);
  EXPECT_EQ(found->b_from_a.translation, again->b_from_a.translation);
}

TEST(EstimateSimilarityTest, ReportsWhatIsMissing) {
  const Camera camera = testing::SyntheticCamera();
  EXPECT_EQ(EstimateSimilarity(camera, camera, Matches(2, 0), {}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(EstimateSimilarity(camera, camera, Matches(15, 0), {}).status().code(),
            absl::StatusCode::kNotFound);
}

std::vector<PoseObservation> Observations(const Rigid3d& pose, int count, int wrong) {
  const Camera camera = testing::SyntheticCamera();
  std::vector<PoseObservation> observations;
  for (const Eigen::Vector3d& x : RandomPoints(count)) {
    observations.push_back({pose.Inverse() * x, Project(camera, x)});
  }
  for (int i = 0; i < wrong; ++i) observations[static_cast<size_t>(i)].pixel.x() += 50 + i;
  return observations;
}

TEST(EstimatePoseTest, FindsFarPosesAmongWrongMatches) {
  const Rigid3d near = ExpSE3((Vector6d() << 1, 2, 3, 0.5, -0.4, 0.3).finished());
  const Rigid3d far{ExpSO3({2, 1, -1}), {500, -300, 100}};
  for (const Rigid3d& truth : {near, near.Inverse(), far}) {
    const auto observations = Observations(truth, 60, 24);
    const auto found = EstimatePose(testing::SyntheticCamera(), observations, {});
    ASSERT_TRUE(found.ok()) << found.status();
    EXPECT_EQ(found->inliers, 36);
    EXPECT_LT((CameraCentre(found->camera_from_map) - CameraCentre(truth)).norm(), 1e-3);
    const auto again = EstimatePose(testing::SyntheticCamera(), observations, {});
    EXPECT_EQ(found->camera_from_map.translation, again->camera_from_map.translation);
  }
}

TEST(EstimatePoseTest, RefusesDegenerateInput) {
  const Camera camera = testing::SyntheticCamera();
  auto observations = Observations({}, 20, 0);
  EXPECT_EQ(EstimatePose(camera, {observations.data(), 3}, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(EstimatePose(camera, {observations.data(), 8}, {}).status().code(),
            absl::StatusCode::kNotFound);
  for (PoseObservation& o : observations) o.x_in_map = Eigen::Vector3d(1, 1, 5);
  EXPECT_EQ(EstimatePose(camera, observations, {}).status().code(), absl::StatusCode::kNotFound);
  observations[4].pixel.x() = NAN;
  EXPECT_EQ(EstimatePose(camera, observations, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
}

const Rigid3d kSecond = {ExpSO3({0.02, -0.06, 0.01}), {-0.8, 0.05, 0.1}};

TEST(TriangulatePointTest, FindsThePointInAnyFrame) {
  const Camera camera = testing::SyntheticCamera();
  const Eigen::Vector3d x(0.5, -0.3, 6);
  const Rigid3d shift{ExpSO3({1, 2, 0.5}), {30, -20, 10}};
  for (const Rigid3d& frame : {Rigid3d::Identity(), shift}) {
    const auto point = TriangulatePoint(camera, frame, Project(camera, x), camera, kSecond * frame,
                                        Project(camera, kSecond * x));
    ASSERT_TRUE(point.has_value());
    EXPECT_LT((frame * point->x_in_map - x).norm(), 1e-9);
    EXPECT_NEAR(point->depth_1, 6, 1e-9);
    EXPECT_LT(point->parallax_cosine, 0.995);
  }
}

TEST(TriangulatePointTest, NothingForParallelOrPartingRays) {
  const Camera camera = testing::SyntheticCamera();
  const Rigid3d right{Eigen::Quaterniond::Identity(), {-1, 0, 0}};
  EXPECT_FALSE(TriangulatePoint(camera, {}, {300, 200}, camera, right, {300, 200}).has_value());
  EXPECT_FALSE(TriangulatePoint(camera, {}, {300, 200}, camera, right, {330, 200}).has_value());
  EXPECT_TRUE(TriangulatePoint(camera, {}, {330, 200}, camera, right, {300, 200}).has_value());
}

}  // namespace
}  // namespace corbslam
