#include "slam/inertial/inertial_odometry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "absl/strings/str_format.h"
#include "slam/inertial/testing/felt_path.h"

namespace corbslam {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr int64_t kSecond_ns = 1'000'000'000;
constexpr int64_t kRobotFrame_ns = 50'000'000;
const ImuNoise kRobotNoise{1.7e-4, 2e-3, 1.9e-5, 3e-3};
const ImuBiases kRobotBiases{{0.01, -0.01, 0.02}, {0.05, 0.05, -0.05}};

ImuCalibration Calibration() {
  ImuCalibration calibration;
  calibration.noise = kRobotNoise;
  // As cameras look along z and IMUs lie flat: x of the IMU is where the camera looks.
  Eigen::Matrix3d turn;
  turn << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  calibration.imu_from_camera = {Eigen::Quaterniond(turn), {0.05, 0.02, -0.03}};
  return calibration;
}

// A robot whose camera is tracked along a path.
class Robot {
 public:
  explicit Robot(ImuPath path, ImuCalibration calibration = Calibration())
      : path_(std::move(path)),
        imu_from_camera_(Calibration().imu_from_camera),
        odometry_(calibration, Rigid3d::Identity()),
        samples_(
            FeltAlong(path_, -kSecond_ns, 60 * kSecond_ns, 200, kRobotNoise, kRobotBiases, 7)) {}

  // What the IMU's driver makes of samples.
  std::function<ImuSample(ImuSample)> driver = [](ImuSample sample) { return sample; };

  Rigid3d WorldFromCamera(int64_t time_ns) const {
    return PathAt(path_, time_ns) * imu_from_camera_;
  }

  // Frames up to a time, each tracked.
  void Drive(int64_t until_ns) {
    for (; now_ns_ <= until_ns; now_ns_ += kRobotFrame_ns) {
      GiveSamples(now_ns_);
      std::optional<Rigid3d> motion;
      if (last_ns_.has_value()) motion = TrueMotion(now_ns_);
      Matrix6d covariance = Matrix6d::Identity() * 1e-8;
      odometry_.Track(now_ns_, motion, covariance);
      last_ns_ = now_ns_;
    }
  }
  // Frames up to a time, none tracked.
  void DriveBlind(int64_t until_ns) {
    for (; now_ns_ <= until_ns; now_ns_ += kRobotFrame_ns) GiveSamples(now_ns_);
  }
  void GiveSamples(int64_t until_ns) {
    ImuSamples given;
    for (; next_ < samples_.size() && samples_[next_].timestamp_ns < until_ns + 5'000'000;
         ++next_) {
      given.push_back(driver(samples_[next_]));
    }
    odometry_.Add(given);
  }
  void LoseSamples(int64_t until_ns) {
    while (samples_[next_].timestamp_ns < until_ns) ++next_;
  }

  // camera_from_previous since the last frame that was tracked.
  Rigid3d TrueMotion(int64_t time_ns) const {
    return WorldFromCamera(time_ns).Inverse() * WorldFromCamera(*last_ns_);
  }

  void Forget() { last_ns_.reset(); }
  int64_t newest_ns() const { return now_ns_ - kRobotFrame_ns; }
  InertialOdometry& odometry() { return odometry_; }

 private:
  const ImuPath path_;
  const Rigid3d imu_from_camera_;
  InertialOdometry odometry_;
  const ImuSamples samples_;
  size_t next_ = 0;
  int64_t now_ns_ = 0;
  std::optional<int64_t> last_ns_;
};

double Off_m(const InertialMotion& motion, const Rigid3d& truth) {
  return (motion.camera_from_previous * truth.Inverse()).translation.norm();
}

TEST(InertialOdometryTest, SaysTheMotionToTheNextFrame) {
  Robot robot(FlownPath);
  robot.Drive(5 * kSecond_ns);
  robot.DriveBlind(5 * kSecond_ns + kRobotFrame_ns);
  const auto motion = robot.odometry().Since(robot.newest_ns());
  ASSERT_TRUE(motion.has_value());
  EXPECT_EQ(motion->since_ns, kRobotFrame_ns);
  const Rigid3d truth = robot.TrueMotion(robot.newest_ns());
  EXPECT_LT(Off_m(*motion, truth), 0.004);
  EXPECT_LT(RotationAngle(motion->camera_from_previous.rotation * truth.rotation.conjugate()),
            0.002);
}

TEST(InertialOdometryTest, IsNotReadyInTheFirstSecond) {
  Robot robot(FlownPath);
  robot.Drive(kSecond_ns / 2);
  EXPECT_FALSE(robot.odometry().Since(kSecond_ns / 2 + kRobotFrame_ns).has_value());
  EXPECT_FALSE(robot.odometry().state().is_ready);
}

TEST(InertialOdometryTest, IsReadyAfterFiveSecondsHoweverItBegins) {
  const auto stands = [](double) { return Rigid3d(); };
  const auto drives = [](double t_s) {
    Rigid3d pose;
    pose.translation = {8 * t_s + std::sin(t_s), 3 * std::sin(0.3 * t_s), 0};
    pose.rotation = ExpSO3({0, 0, 0.2 * std::sin(0.3 * t_s)});
    return pose;
  };
  for (const ImuPath& path : {ImuPath(FlownPath), ImuPath(stands), ImuPath(drives)}) {
    Robot robot(path);
    robot.Drive(5 * kSecond_ns);
    const InertialState state = robot.odometry().state();
    EXPECT_TRUE(state.is_ready);
    ASSERT_TRUE(state.down.has_value());
    const Eigen::Vector3d truth =
        robot.WorldFromCamera(robot.newest_ns()).rotation.conjugate() * Eigen::Vector3d(0, 0, -1);
    const double off_rad = std::acos(std::min(1.0, state.down->in_camera.dot(truth)));
    EXPECT_LT(off_rad, 3 * state.down->sigma_rad + 0.002);
    EXPECT_LT(off_rad, 0.03);
    EXPECT_THAT(robot.odometry().TakeDoubts(), IsEmpty());
  }
}

TEST(InertialOdometryTest, GoesOnWithoutPicturesForThreeSecondsWithinItsSigmas) {
  Robot robot(FlownPath);
  robot.Drive(10 * kSecond_ns);
  robot.DriveBlind(13 * kSecond_ns);
  const auto motion = robot.odometry().Since(robot.newest_ns());
  ASSERT_TRUE(motion.has_value());
  const Rigid3d error =
      motion->camera_from_previous.Inverse() * robot.TrueMotion(robot.newest_ns());
  EXPECT_LT(error.translation.norm(), 0.4);
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(std::abs(error.translation(i)), 3 * std::sqrt(motion->covariance(i, i)));
  }
  EXPECT_LT(RotationAngle(error.rotation),
            3 * std::sqrt(motion->covariance.bottomRightCorner<3, 3>().trace()));
}

TEST(InertialOdometryTest, NobodyKnowsTheMotionAfterFiveSeconds) {
  Robot robot(FlownPath);
  robot.Drive(10 * kSecond_ns);
  robot.DriveBlind(15 * kSecond_ns + 2 * kRobotFrame_ns);
  EXPECT_FALSE(robot.odometry().Since(robot.newest_ns()).has_value());
}

TEST(InertialOdometryTest, TakesPicturesThatComeBack) {
  Robot robot(FlownPath);
  robot.Drive(10 * kSecond_ns);
  robot.DriveBlind(12 * kSecond_ns);
  robot.Drive(13 * kSecond_ns);
  robot.DriveBlind(13 * kSecond_ns + kRobotFrame_ns);
  const auto motion = robot.odometry().Since(robot.newest_ns());
  ASSERT_TRUE(motion.has_value());
  EXPECT_LT(Off_m(*motion, robot.TrueMotion(robot.newest_ns())), 0.005);
  EXPECT_THAT(robot.odometry().TakeDoubts(), IsEmpty());
}

TEST(InertialOdometryTest, WhatIsKnownOutlivesTheMapThatPicturesBeganAnew) {
  Robot robot(FlownPath);
  robot.Drive(10 * kSecond_ns);
  robot.DriveBlind(11 * kSecond_ns);
  robot.Forget();
  robot.Drive(11 * kSecond_ns + kRobotFrame_ns);
  EXPECT_TRUE(robot.odometry().state().is_ready);
  robot.DriveBlind(12 * kSecond_ns);
  const auto motion = robot.odometry().Since(robot.newest_ns());
  ASSERT_TRUE(motion.has_value());
  EXPECT_LT(Off_m(*motion, robot.TrueMotion(robot.newest_ns())), 0.15);
}

TEST(InertialOdometryTest, WhatStandsInTheDarkStaysPut) {
  // It slows down from 8 s on, and comes to rest at 10 s.
  Robot robot([](double t_s) {
    const double slowing_s = std::clamp(t_s - 8, 0.0, 2.0);
    return FlownPath(std::min(t_s, 8.0) + slowing_s - slowing_s * slowing_s / 4);
  });
  robot.Drive(11 * kSecond_ns);
  robot.DriveBlind(15 * kSecond_ns);
  const auto motion = robot.odometry().Since(robot.newest_ns());
  ASSERT_TRUE(motion.has_value());
  EXPECT_LT(motion->camera_from_previous.translation.norm(), 0.02);
}

TEST(InertialOdometryTest, WhatRollsOnEvenlyIsNotTakenToStand) {
  Robot robot([](double t_s) {
    Rigid3d pose;
    const double evenly_s = std::max(0.0, t_s - 8);
    pose.translation = {std::sin(std::min(t_s, 8.0)) + std::cos(8.0) * evenly_s, 0, 0};
    pose.rotation = ExpSO3({0, 0, 0.3 * std::sin(std::min(t_s, 8.0))});
    return pose;
  });
  robot.Drive(10 * kSecond_ns);
  robot.DriveBlind(13 * kSecond_ns);
  const auto motion = robot.odometry().Since(robot.newest_ns());
  ASSERT_TRUE(motion.has_value());
  EXPECT_LT(Off_m(*motion, robot.TrueMotion(robot.newest_ns())), 0.2);
}

TEST(InertialOdometryTest, AGapIsToldAndThenItGoesOn) {
  Robot robot(FlownPath);
  robot.Drive(5 * kSecond_ns);
  robot.LoseSamples(5 * kSecond_ns + 300'000'000);
  robot.Drive(5 * kSecond_ns + 500'000'000);
  const auto doubts = robot.odometry().TakeDoubts();
  ASSERT_THAT(doubts, SizeIs(1));
  EXPECT_EQ(doubts[0].kind, InertialDoubt::Kind::kGap);
  EXPECT_THAT(doubts[0].text, HasSubstr("samples of the IMU are missing"));
  EXPECT_FALSE(robot.odometry().Since(robot.newest_ns() + kRobotFrame_ns).has_value());
  robot.Drive(9 * kSecond_ns);
  EXPECT_TRUE(robot.odometry().state().is_ready);
}

TEST(InertialOdometryTest, AnImuThatSaysNothingIsTold) {
  Robot robot(FlownPath);
  robot.LoseSamples(50 * kSecond_ns);
  robot.Drive(3 * kSecond_ns);
  const auto doubts = robot.odometry().TakeDoubts();
  ASSERT_THAT(doubts, SizeIs(1));
  EXPECT_EQ(doubts[0].kind, InertialDoubt::Kind::kMissing);
}

TEST(InertialOdometryTest, StampsThatAreLateAreToldAndPutRight) {
  Robot robot(FlownPath);
  robot.driver = [](ImuSample sample) {
    sample.timestamp_ns += 120'000'000;
    return sample;
  };
  robot.Drive(15 * kSecond_ns);
  const auto doubts = robot.odometry().TakeDoubts();
  ASSERT_THAT(doubts, SizeIs(1));
  EXPECT_EQ(doubts[0].kind, InertialDoubt::Kind::kLate);
  EXPECT_THAT(doubts[0].text, HasSubstr("right by -0.12"));
  EXPECT_TRUE(robot.odometry().state().is_ready);
  EXPECT_LT(std::abs(robot.odometry().state().late_s), 0.003);
  robot.DriveBlind(16 * kSecond_ns);
  const auto motion = robot.odometry().Since(robot.newest_ns());
  ASSERT_TRUE(motion.has_value());
  EXPECT_LT(Off_m(*motion, robot.TrueMotion(robot.newest_ns())), 0.1);
}

// A drive ahead that turns and swings by a share of what FlownPath does.
ImuPath SwingsBy(double share) {
  return [share](double t_s) {
    Rigid3d pose;
    pose.translation = {0.4 * t_s, share * 1.1 * std::sin(0.7 * t_s + 1),
                        share * 0.4 * std::sin(1.3 * t_s)};
    pose.rotation =
        ExpSO3({0, 0, share * 0.8 * std::sin(0.5 * t_s)}) *
        ExpSO3({share * 0.25 * std::sin(1.1 * t_s), share * 0.2 * std::sin(1.7 * t_s + 0.3), 0});
    return pose;
  };
}

class LateInAGentleDriveTest : public ::testing::TestWithParam<std::tuple<int, double>> {};

TEST_P(LateInAGentleDriveTest, NeverTakesTheCameraFurtherWrongThanItSays) {
  const auto [late_ms, share] = GetParam();
  Robot robot(SwingsBy(share));
  robot.driver = [late_ns = late_ms * int64_t{1'000'000}](ImuSample sample) {
    sample.timestamp_ns += late_ns;
    return sample;
  };
  int said = 0;
  for (int second = 1; second <= 14; ++second) {
    robot.Drive(second * kSecond_ns);
    Robot blind = robot;
    blind.DriveBlind((second + 1) * kSecond_ns);
    const auto motion = blind.odometry().Since(blind.newest_ns());
    if (!motion.has_value()) continue;
    ++said;
    const Eigen::Vector3d off =
        (motion->camera_from_previous.Inverse() * blind.TrueMotion(blind.newest_ns())).translation;
    const Eigen::Matrix3d covariance = motion->covariance.topLeftCorner<3, 3>();
    EXPECT_LT(std::sqrt(off.dot(covariance.inverse() * off)), 3.5) << "after " << second << " s";
  }
  EXPECT_GE(said, 9);
}

INSTANTIATE_TEST_SUITE_P(, LateInAGentleDriveTest,
                         ::testing::Combine(::testing::Values(20, 40, 80, 120, 300),
                                            ::testing::Values(0.02, 0.05, 0.1, 0.2, 0.4, 1.0)),
                         [](const auto& info) {
                           return absl::StrFormat("By%dMsSwingingByPerCent%.0f",
                                                  std::get<0>(info.param),
                                                  100 * std::get<1>(info.param));
                         });

TEST(InertialOdometryTest, ADriveWhoseTimeGoesBackIsLearntAnew) {
  Robot first(FlownPath);
  first.Drive(5 * kSecond_ns);
  ASSERT_TRUE(first.odometry().state().is_ready);
  InertialOdometry odometry = first.odometry();
  const ImuSamples again =
      FeltAlong(FlownPath, -kSecond_ns, 5 * kSecond_ns, 200, kRobotNoise, kRobotBiases, 8);
  size_t next = 0;
  for (int64_t now_ns = 0; now_ns <= 3 * kSecond_ns; now_ns += kRobotFrame_ns) {
    ImuSamples given;
    while (again[next].timestamp_ns < now_ns + 5'000'000) given.push_back(again[next++]);
    odometry.Add(given);
    std::optional<Rigid3d> motion;
    if (now_ns > 0) {
      motion =
          first.WorldFromCamera(now_ns).Inverse() * first.WorldFromCamera(now_ns - kRobotFrame_ns);
    }
    odometry.Track(now_ns, motion, Matrix6d::Identity() * 1e-8);
    if (now_ns < kSecond_ns) {
      EXPECT_FALSE(odometry.state().is_ready);
    }
  }
  EXPECT_TRUE(odometry.state().is_ready);
  EXPECT_THAT(odometry.TakeDoubts(), IsEmpty());
}

// What is wrong, and what must be said of it.
struct Wrong {
  const char* name;
  std::function<ImuSample(ImuSample)> driver;
  const char* said;

  friend void PrintTo(const Wrong& wrong, std::ostream* out) { *out << wrong.name; }
};

class WrongImuTest : public ::testing::TestWithParam<Wrong> {};

TEST_P(WrongImuTest, IsToldAndNotUsed) {
  Robot robot(FlownPath);
  robot.driver = GetParam().driver;
  robot.Drive(15 * kSecond_ns);
  const auto doubts = robot.odometry().TakeDoubts();
  ASSERT_THAT(doubts, SizeIs(1));
  EXPECT_EQ(doubts[0].kind, InertialDoubt::Kind::kContradicts);
  EXPECT_THAT(doubts[0].text, HasSubstr(GetParam().said));
  EXPECT_FALSE(robot.odometry().Since(robot.newest_ns() + kRobotFrame_ns).has_value());
}

INSTANTIATE_TEST_SUITE_P(
    Wrongs, WrongImuTest,
    ::testing::Values(Wrong{"AxesExchanged",
                            [](ImuSample s) {
                              std::swap(s.angular_velocity_rps.x(), s.angular_velocity_rps.y());
                              std::swap(s.specific_force_mps2.x(), s.specific_force_mps2.y());
                              s.angular_velocity_rps.z() *= -1;
                              s.specific_force_mps2.z() *= -1;
                              return s;
                            },
                            "axes are turned by 180 degrees"},
                      Wrong{"Degrees",
                            [](ImuSample s) {
                              s.angular_velocity_rps *= 180 / M_PI;
                              return s;
                            },
                            "degrees a second?"},
                      Wrong{"GyroTheOtherWay",
                            [](ImuSample s) {
                              s.angular_velocity_rps *= -1;
                              return s;
                            },
                            "turned by 180 degrees"},
                      Wrong{"GravityAsUnit",
                            [](ImuSample s) {
                              s.specific_force_mps2 /= kGravity_mps2;
                              return s;
                            },
                            "what the IMU feels and what the camera sees contradict"},
                      Wrong{"AccelTheOtherWay",
                            [](ImuSample s) {
                              s.specific_force_mps2 *= -1;
                              return s;
                            },
                            "what the IMU feels and what the camera sees contradict"}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace corbslam
