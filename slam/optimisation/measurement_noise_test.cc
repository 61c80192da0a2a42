#include "slam/optimisation/measurement_noise.h"

#include <gtest/gtest.h>

#include <random>

#include "slam/optimisation/block_schur_solver.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam {
namespace {

// Cameras stand in a row before a wall with hills. The last one is held.
class MeasureNoiseTest : public ::testing::Test {
 protected:
  MeasureNoiseTest() : camera_(testing::SyntheticCamera()) {
    for (int i = 0; i < 8; ++i) {
      problem_.poses.push_back(
          {Eigen::Matrix3d::Identity(), Eigen::Vector3d(-0.3 * i, 0, 0), &camera_});
    }
    problem_.free_poses = 7;
    problem_.free_points = 600;
    for (uint32_t p = 0; p < problem_.free_points; ++p) {
      problem_.points.emplace_back(Uniform(-3, 5), Uniform(-3, 3), Uniform(5, 15));
    }
  }

  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  // Lets `sightings` of the cameras, one after the other, see each point.
  void See(double noise_px, uint32_t sightings = 4) {
    std::normal_distribution<double> noise(0, noise_px);
    for (uint32_t p = 0; p < problem_.points.size(); ++p) {
      for (uint32_t s = 0; s < sightings; ++s) {
        const uint32_t pose = p % 5 + s;
        const Eigen::Vector3d x = problem_.poses[pose].ToCamera(problem_.points[p]);
        const Eigen::Vector3d exact =
            ReprojectionResidual(camera_, x, MakeMeasurement({0, 0}, 1, 1));
        PixelMeasurement measured;
        measured.has_depth = true;
        measured.pixel = exact - Eigen::Vector3d(0, 0, 1);
        for (double& coordinate : measured.pixel) coordinate += noise(random_);
        problem_.observations.push_back({pose, p, measured, true});
      }
    }
  }

  MinimiseSummary Minimise(bool robust) {
    MinimiseOptions options;
    options.max_iterations = 30;
    options.robust = robust;
    return BlockSchurSolver(1, problem_).Minimise(options);
  }

  const Camera camera_;
  std::mt19937_64 random_{7};
  BundleProblem problem_;
};

TEST_F(MeasureNoiseTest, IsThatOfTheInliersAtTheMinimum) {
  See(0.3);
  for (size_t i = 0; i < problem_.observations.size(); i += 21) {
    problem_.observations[i].measured.pixel.x() += 30;
  }
  ASSERT_FALSE(Minimise(true).cancelled);
  // Outliers spoil a fifth of the points, because Huber's loss lets them pull.
  for (const double variance : MeasureNoise(problem_)) {
    EXPECT_GT(variance, 0.08);
    EXPECT_LT(variance, 0.14);
  }
}

// Without outliers the median is that of the noise, and what poses and points took up is added to
// it.
TEST_F(MeasureNoiseTest, CountsWhatPosesAndPointsTookUp) {
  See(0.3, 2);
  ASSERT_FALSE(Minimise(false).cancelled);
  for (const double variance : MeasureNoise(problem_)) EXPECT_NEAR(variance, 0.09, 0.02);
}

TEST_F(MeasureNoiseTest, APoseMayHaveMoreThanTheOthers) {
  problem_.free_poses = problem_.free_points = 0;
  See(0.3);
  for (BundleObservation& o : problem_.observations) {
    if (o.pose == 2) o.measured.pixel.x() += 1.2;
  }
  const std::vector<double> variances = MeasureNoise(problem_);
  EXPECT_GT(variances[2], 3 * variances[0]);
  for (const double variance : variances) EXPECT_GE(variance, 0.08);
}

TEST_F(MeasureNoiseTest, APoseHasNoLessThanAllTogether) {
  problem_.free_poses = problem_.free_points = 0;
  See(0.3);
  for (BundleObservation& o : problem_.observations) {
    const Eigen::Vector3d x = problem_.poses[o.pose].ToCamera(problem_.points[o.point]);
    if (o.pose == 3) o.measured.pixel += ReprojectionResidual(camera_, x, o.measured);
  }
  EXPECT_GT(MeasureNoise(problem_)[3], 0.05);
}

TEST_F(MeasureNoiseTest, IsNeverMoreThanAssumedNorLessThanCornersAllow) {
  problem_.free_poses = problem_.free_points = 0;
  EXPECT_EQ(MeasureNoise(problem_), std::vector<double>(8, 1));
  See(0);
  EXPECT_EQ(MeasureNoise(problem_), std::vector<double>(8, 0.01));
  for (BundleObservation& o : problem_.observations) o.measured.pixel.x() += 5;
  EXPECT_EQ(MeasureNoise(problem_), std::vector<double>(8, 1));
}

TEST_F(MeasureNoiseTest, AFewSightingsSayNothingOfAPose) {
  problem_.free_poses = problem_.free_points = 0;
  See(0.3);
  int kept = 0;
  for (BundleObservation& o : problem_.observations) {
    if (o.pose != 1) continue;
    o.is_used = ++kept <= 20;
    o.measured.pixel.x() += 2;
  }
  EXPECT_LT(MeasureNoise(problem_)[1], 0.12);
}

}  // namespace
}  // namespace corbslam
