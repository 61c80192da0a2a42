#include "services/simulation/sequence/truth_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace corbslam {
namespace {

TEST(TruthErrorTest, NoErrorLeavesThePoseAsItIs) {
  const Rigid3d pose{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY())),
                     {1, 2, 3}};
  const Rigid3d measured = MeasuredPose(pose, 12.5, {});
  EXPECT_EQ(measured.translation, pose.translation);
  EXPECT_EQ(measured.rotation.coeffs(), pose.rotation.coeffs());
}

TEST(TruthErrorTest, DeviatesByWhatIsAskedAndSlowly) {
  const TruthError error{.position_m = 0.2, .orientation_deg = 0.5, .seed = 3};
  double squares = 0;
  double turns = 0;
  double fastest = 0;
  Rigid3d last = MeasuredPose({}, 0, error);
  constexpr int kSteps = 20000;
  for (int i = 1; i <= kSteps; ++i) {
    const Rigid3d measured = MeasuredPose({}, 0.1 * i, error);
    squares += measured.translation.squaredNorm();
    turns += std::pow(RotationAngle(measured.rotation) * 180 / std::numbers::pi, 2);
    fastest = std::max(fastest, (measured.translation - last.translation).norm());
    last = measured;
  }
  EXPECT_NEAR(std::sqrt(squares / kSteps / 3), 0.2, 0.02);
  EXPECT_NEAR(std::sqrt(turns / kSteps / 3), 0.5, 0.05);
  EXPECT_LT(fastest, 0.05);  // Metres in a tenth of a second.
}

TEST(TruthErrorTest, SeedsErrDifferently) {
  const TruthError one{.position_m = 1, .seed = 1};
  const TruthError two{.position_m = 1, .seed = 2};
  EXPECT_GT((MeasuredPose({}, 5, one).translation - MeasuredPose({}, 5, two).translation).norm(),
            0.01);
  EXPECT_EQ(MeasuredPose({}, 5, one).translation, MeasuredPose({}, 5, one).translation);
}

}  // namespace
}  // namespace corbslam
