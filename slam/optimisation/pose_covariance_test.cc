#include "slam/optimisation/pose_covariance.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>
#include <vector>

#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam {
namespace {

const Rigid3d kPose = ExpSE3((Vector6d() << 0.4, -0.2, 0.3, 0.1, -0.2, 0.15).finished());

// Draws frames of random points with Gaussian noise.
class NoisyFrames {
 public:
  explicit NoisyFrames(double noise_px) : noise_px_(noise_px) {}

  std::vector<PoseObservation> Draw(int points) {
    std::vector<PoseObservation> observations;
    while (static_cast<int>(observations.size()) < points) {
      const double z = 2 + 8 * uniform_(random_);
      const double x_px = camera_.width_px * uniform_(random_);
      const double y_px = camera_.height_px * uniform_(random_);
      const Eigen::Vector3d x_in_camera = Unproject(camera_, x_px, y_px, z);
      const double disparity_px = DisparityFromDepth(camera_, z);
      observations.push_back({kPose.Inverse() * x_in_camera,
                              {x_px + Noise(), y_px + Noise()},
                              disparity_px,
                              /*variance_px2=*/1});
      // The right pixel's noise is its own.
      observations.back().disparity_px =
          observations.back().pixel.x() - (x_px - disparity_px + Noise());
    }
    return observations;
  }
  const Camera& camera() const { return camera_; }

 private:
  double Noise() { return noise_px_ * normal_(random_); }

  const double noise_px_;
  const Camera camera_ = testing::SyntheticCamera();
  std::mt19937 random_{7};
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_;
};

// The squared error of a pose in units of its covariance is distributed as chi2 with six degrees of
// freedom: its mean over n draws has a standard deviation of sqrt(12 / n).
void ExpectConsistent(double noise_px) {
  constexpr int kDraws = 400;
  NoisyFrames frames(noise_px);
  double in_camera = 0;
  double in_map = 0;
  for (int i = 0; i < kDraws; ++i) {
    const std::vector<PoseObservation> observations = frames.Draw(400);
    const PoseEstimate estimate = OptimisePose(frames.camera(), kPose, observations);
    std::vector<PoseObservation> inliers;
    for (size_t k = 0; k < observations.size(); ++k) {
      if (estimate.is_inlier[k]) inliers.push_back(observations[k]);
    }
    const auto covariance = PoseCovariance(frames.camera(), estimate.camera_from_map, inliers);
    ASSERT_TRUE(covariance.has_value());
    const Rigid3d error = kPose * estimate.camera_from_map.Inverse();
    const Vector6d e = LogSE3(error);
    in_camera += e.dot(covariance->inverse() * e) / kDraws;
    Vector6d m;
    const Rigid3d map_from_camera = estimate.camera_from_map.Inverse();
    m << CameraCentre(kPose) - CameraCentre(estimate.camera_from_map),
        LogSO3(kPose.Inverse().rotation * map_from_camera.rotation.conjugate());
    in_map += m.dot(InMapAxes(estimate.camera_from_map, *covariance).inverse() * m) / kDraws;
  }
  // Four standard deviations, and what dropping the worst twentieth of the residuals does.
  EXPECT_NEAR(in_camera, 6, 4 * std::sqrt(12.0 / kDraws) + 0.6) << noise_px;
  EXPECT_NEAR(in_map, 6, 4 * std::sqrt(12.0 / kDraws) + 0.6) << noise_px;
}

TEST(PoseCovarianceTest, ErrorsAreAsLargeAsItSays) { ExpectConsistent(0.3); }

TEST(PoseCovarianceTest, TheNoiseIsMeasuredAndNotAssumed) { ExpectConsistent(0.05); }

TEST(PoseCovarianceTest, NoneWherePointsDoNotDetermineThePose) {
  NoisyFrames frames(0.1);
  EXPECT_FALSE(PoseCovariance(frames.camera(), kPose, {}).has_value());
  EXPECT_FALSE(PoseCovariance(frames.camera(), kPose, frames.Draw(3)).has_value());
  std::vector<PoseObservation> one_place = frames.Draw(1);
  one_place.resize(50, one_place.front());
  EXPECT_FALSE(PoseCovariance(frames.camera(), kPose, one_place).has_value());
}

TEST(PoseCovarianceTest, AnAttachedFrameMovesWithTheCamerasRotation) {
  Matrix6d covariance = Matrix6d::Zero();
  covariance(5, 5) = 0.01;  // About z alone.
  const Rigid3d camera_from_attached{Eigen::Quaterniond::Identity(), {2, 0, 0}};
  const Matrix6d of = OfAttachedFrame(Rigid3d::Identity(), camera_from_attached, covariance);
  EXPECT_NEAR(of(0, 0), 0, 1e-12);
  EXPECT_NEAR(of(1, 1), 0.04, 1e-12) << "two metres away it moves sideways";
  EXPECT_NEAR(of(1, 5), 0.02, 1e-12) << "forwards along y when it turns left";
  EXPECT_NEAR(of(5, 5), 0.01, 1e-12);
}

}  // namespace
}  // namespace corbslam
