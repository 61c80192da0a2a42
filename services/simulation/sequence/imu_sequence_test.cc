#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <numbers>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <thread>
#include <variant>

#include "services/simulation/motion/drives.h"
#include "services/simulation/sequence/simulated_sequence.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/geometry/lie.h"

namespace corbslam {
namespace {

using ::testing::HasSubstr;

// Truth is known at each sample's time and between: poses cost nothing.
constexpr double kTruthRate_hz = 1000;
constexpr double kImuRate_hz = 250;
constexpr int64_t kHalf_ns = 2'000'000;  // Of a sample's period.

SimulationSpec ImuSpecOf(SimulatedWorld world, FloorMotion motion = FloorMotion::kWalk) {
  SimulationSpec spec;
  spec.world = world;
  spec.motion = motion;
  spec.seed = 3;
  spec.length_m = 400;
  spec.rate_hz = kTruthRate_hz;
  spec.imu.grade = ImuGrade::kIdeal;
  spec.imu.rate_hz = kImuRate_hz;
  return spec;
}

std::unique_ptr<SimulatedSequence> OpenImu(const SimulationSpec& spec) {
  absl::StatusOr<std::unique_ptr<SimulatedSequence>> sequence = SimulatedSequence::Make(spec);
  EXPECT_TRUE(sequence.ok()) << sequence.status();
  return *std::move(sequence);
}

ImuCalibration CalibrationOf(const SimulatedSequence& sequence) {
  return *std::visit([](const auto& sensor) { return sensor.imu; }, sequence.calibration());
}

struct State {
  Rigid3d world_from_imu;
  Eigen::Vector3d velocity_mps;
};

const Eigen::Vector3d kGravity(0, kGravity_mps2, 0);

// Goes on by one period, over which a sample is the mean.
void Hold(const ImuSample& sample, State& state) {
  const double step_s = 1 / kImuRate_hz;
  Eigen::Quaterniond& rotation = state.world_from_imu.rotation;
  const Eigen::Quaterniond middle = rotation * ExpSO3(0.5 * step_s * sample.angular_velocity_rps);
  const Eigen::Vector3d acceleration = middle * sample.specific_force_mps2 + kGravity;
  state.world_from_imu.translation +=
      step_s * state.velocity_mps + 0.5 * step_s * step_s * acceleration;
  state.velocity_mps += step_s * acceleration;
  rotation = (rotation * ExpSO3(step_s * sample.angular_velocity_rps)).normalized();
}

// Goes on from one sample to the next by the mean of both, as estimators do.
void Step(const ImuSample& from, const ImuSample& to, State& state) {
  const double step_s = 1 / kImuRate_hz;
  const Eigen::Vector3d turn = 0.5 * (from.angular_velocity_rps + to.angular_velocity_rps);
  Eigen::Quaterniond& rotation = state.world_from_imu.rotation;
  const Eigen::Vector3d first = rotation * from.specific_force_mps2 + kGravity;
  rotation = (rotation * ExpSO3(step_s * turn)).normalized();
  const Eigen::Vector3d second = rotation * to.specific_force_mps2 + kGravity;
  state.world_from_imu.translation +=
      step_s * state.velocity_mps + step_s * step_s / 6 * (2 * first + second);
  state.velocity_mps += 0.5 * step_s * (first + second);
}

struct Drift {
  double metres = 0;
  double degrees = 0;
};

enum class Rule { kHold, kStep };

// Returns how far from the truth ten seconds of samples end that begin at the true pose and
// velocity.
Drift DriftOf(const SimulatedSequence& sequence, double from_s, Rule rule) {
  const Rigid3d camera_from_imu = CalibrationOf(sequence).imu_from_camera.Inverse();
  const auto truth = [&](int64_t time_ns) {
    return sequence.world_from_camera(static_cast<size_t>(time_ns / 1'000'000)) * camera_from_imu;
  };
  const auto first = static_cast<size_t>(std::lround(from_s * kImuRate_hz));
  const size_t end = first + static_cast<size_t>(10 * kImuRate_hz);
  const ImuSamples& samples = sequence.imu();
  const int64_t before_ns = rule == Rule::kHold ? kHalf_ns : 0;
  const int64_t begin_ns = samples[first].timestamp_ns - before_ns;
  State state;
  state.world_from_imu = truth(begin_ns);
  state.velocity_mps =
      (truth(begin_ns + 1'000'000).translation - truth(begin_ns - 1'000'000).translation) / 2e-3;
  for (size_t i = first; i < end; ++i) {
    rule == Rule::kHold ? Hold(samples[i], state) : Step(samples[i], samples[i + 1], state);
  }
  const Rigid3d there = truth(samples[end].timestamp_ns - before_ns);
  return {(state.world_from_imu.translation - there.translation).norm(),
          RotationAngle(state.world_from_imu.rotation.conjugate() * there.rotation) * 180 /
              std::numbers::pi};
}

// Looks at ten seconds after ten seconds. They begin between two poses of the way: at a pose
// acceleration jumps, and a sample is the mean of what is before and behind.
Drift WorstDrift(const SimulatedSequence& sequence, Rule rule) {
  Drift worst;
  for (double from_s = 0.512; from_s + 11 < 1e-3 * static_cast<double>(sequence.frame_count());
       from_s += 5) {
    const Drift drift = DriftOf(sequence, from_s, rule);
    worst.metres = std::max(worst.metres, drift.metres);
    worst.degrees = std::max(worst.degrees, drift.degrees);
  }
  EXPECT_GT(worst.metres, 0);  // There were ten seconds to look at.
  return worst;
}

void ExpectNoDrift(const SimulationSpec& spec, const std::string& name, double most_by_steps_m) {
  const auto sequence = OpenImu(spec);
  const Drift held = WorstDrift(*sequence, Rule::kHold);
  EXPECT_LT(held.metres, 0.001) << name;
  EXPECT_LT(held.degrees, 0.001) << name;
  const Drift stepped = WorstDrift(*sequence, Rule::kStep);
  EXPECT_LT(stepped.metres, most_by_steps_m) << name;
  EXPECT_LT(stepped.degrees, 0.01) << name;
  std::cout << name << ": after 10 s at most " << 1e3 * held.metres << " mm and " << held.degrees
            << " degrees held, " << 1e3 * stepped.metres << " mm and " << stepped.degrees
            << " degrees by steps\n";
}

TEST(ImuSequenceTest, IntegratesToTheTruthInEachWorld) {
  ExpectNoDrift(ImuSpecOf(SimulatedWorld::kCity), "city", 0.01);
  ExpectNoDrift(ImuSpecOf(SimulatedWorld::kFloor), "walk", 0.01);
  // Where the drone's height meets its bounds it is stopped at once.
  ExpectNoDrift(ImuSpecOf(SimulatedWorld::kFloor, FloorMotion::kFly), "fly", 0.04);
  SimulationSpec path = ImuSpecOf(SimulatedWorld::kPath);
  path.poses = ::testing::TempDir() + "/imu_poses.txt";
  Trajectory poses;
  for (const Rigid3d& pose : DriveThroughTown({.seed = 5, .length_m = 400})) {
    poses.push_back({static_cast<int64_t>(poses.size()) * 100'000'000, pose});
  }
  ASSERT_TRUE(WriteKittiTrajectory(poses, path.poses).ok());
  ExpectNoDrift(path, "path", 0.01);
}

TEST(ImuSequenceTest, IntegratesToTheTruthTurnedLaterAndFromAStand) {
  SimulationSpec turned = ImuSpecOf(SimulatedWorld::kFloor);
  turned.turned = true;
  ExpectNoDrift(turned, "turned", 0.01);
  SimulationSpec standing = ImuSpecOf(SimulatedWorld::kCity);
  standing.beginning = {1, 0, 1};
  standing.set_off_s = 3;
  ExpectNoDrift(standing, "from a stand", 0.01);
  standing.turned = true;
  ExpectNoDrift(standing, "turned, from a stand", 0.01);
}

TEST(ImuSequenceTest, StandsBeforeItSetsOff) {
  SimulationSpec spec = ImuSpecOf(SimulatedWorld::kFloor);
  spec.beginning = {1, 1, 1};
  spec.set_off_s = 2;
  spec.start_s = 100;
  const auto sequence = OpenImu(spec);
  EXPECT_EQ(sequence->imu().front().timestamp_ns, 100'000'000'000);
  double fastest = 0;
  for (const ImuSample& sample : sequence->imu()) {
    const double time_s = 1e-9 * static_cast<double>(sample.timestamp_ns) - 100;
    const double beyond = std::abs(sample.specific_force_mps2.norm() - kGravity_mps2);
    if (time_s < 2.99) {
      EXPECT_LT(sample.angular_velocity_rps.norm(), 1e-9);
      EXPECT_LT(beyond, 1e-6);
    } else if (time_s < 5) {
      fastest = std::max(fastest, beyond);
    }
  }
  EXPECT_GT(fastest, 0.1);
  EXPECT_LT(fastest, 5);
}

TEST(ImuSequenceTest, ThereIsNoneUnlessItIsAskedFor) {
  SimulationSpec spec = ImuSpecOf(SimulatedWorld::kCity);
  spec.imu = {};
  const auto without = OpenImu(spec);
  EXPECT_TRUE(without->imu().empty());
  EXPECT_FALSE(std::get<StereoCalibration>(without->calibration()).imu.has_value());
}

TEST(ImuSequenceTest, IsOfTheTimesAndThePosesThatThePicturesHave) {
  SimulationSpec spec = ImuSpecOf(SimulatedWorld::kCity);
  spec.imu = {};
  const auto without = OpenImu(spec);
  spec.imu.grade = ImuGrade::kGood;
  spec.imu.rate_hz = kImuRate_hz;
  const auto with = OpenImu(spec);
  ASSERT_EQ(with->frame_count(), without->frame_count());
  for (size_t i = 0; i < with->frame_count(); i += 97) {
    EXPECT_EQ(with->timestamp_ns(i), without->timestamp_ns(i));
    EXPECT_EQ(with->world_from_camera(i).translation, without->world_from_camera(i).translation);
  }
  const int64_t end_ns = with->timestamp_ns(with->frame_count() - 1);
  EXPECT_EQ(with->imu().front().timestamp_ns, 0);
  EXPECT_NEAR(1e-9 * static_cast<double>(with->imu().back().timestamp_ns - end_ns), 0, 0.005);
  EXPECT_EQ(CalibrationOf(*with).rate_hz, kImuRate_hz);
  EXPECT_EQ(CalibrationOf(*with).noise.gyro, NoiseOf(ImuGrade::kGood).gyro);
  EXPECT_EQ(CalibrationOf(*with).time_offset_s, 0);
}

TEST(ImuSequenceTest, NoiseIsOfTheNoiseSeedAloneWhoeverAsks) {
  SimulationSpec spec = ImuSpecOf(SimulatedWorld::kFloor);
  spec.imu.grade = ImuGrade::kPhone;
  const auto first = OpenImu(spec);
  spec.threads = 3;
  const auto second = OpenImu(spec);
  std::thread other([&] { EXPECT_FALSE(second->imu().empty()); });
  EXPECT_FALSE(second->imu().empty());
  other.join();
  ASSERT_EQ(first->imu().size(), second->imu().size());
  for (size_t i = 0; i < first->imu().size(); ++i) {
    EXPECT_EQ(first->imu()[i].specific_force_mps2, second->imu()[i].specific_force_mps2);
  }
  spec.lens.noise_seed = 2;
  EXPECT_NE(OpenImu(spec)->imu()[7].specific_force_mps2, first->imu()[7].specific_force_mps2);
}

TEST(ImuSequenceTest, ARigSaysWhereItsImuSits) {
  SimulationSpec spec = ImuSpecOf(SimulatedWorld::kCity);
  spec.imu = {};
  SimulatedPair& pair = spec.pair.emplace();
  pair.width_px = 64;
  pair.height_px = 48;
  pair.left.fx_px = pair.left.fy_px = pair.right.fx_px = pair.right.fy_px = 40;
  pair.told.imu.emplace().imu_from_camera.translation = {0.5, 0, 0};
  EXPECT_FALSE(std::get<StereoCalibration>(OpenImu(spec)->calibration()).imu.has_value());
  spec.imu.grade = ImuGrade::kIdeal;
  spec.imu.rate_hz = kImuRate_hz;
  const auto sequence = OpenImu(spec);
  EXPECT_EQ(CalibrationOf(*sequence).imu_from_camera.translation.x(), 0.5);
  EXPECT_LT(DriftOf(*sequence, 1.012, Rule::kHold).metres, 0.01);
}

// Writes a flight's IMU's poses in another frame, z upwards, from 100 s on, and takes what an ideal
// IMU measured along it, with a bias, for a real one's.
SimulationSpec MeasuredFlightSpec(const SimulatedSequence& flight) {
  const ImuCalibration imu = CalibrationOf(flight);
  const Rigid3d frame_from_world = {
      Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()))
          .conjugate(),
      {3, 4, 5}};
  constexpr int64_t kLater_ns = 100'000'000'000;
  Trajectory poses;
  for (size_t i = 500; i < 20'500; i += 5) {
    poses.push_back(
        {flight.timestamp_ns(i) + kLater_ns,
         frame_from_world * flight.world_from_camera(i) * imu.imu_from_camera.Inverse()});
  }
  SimulationSpec spec = ImuSpecOf(SimulatedWorld::kPath);
  spec.poses = ::testing::TempDir() + "/flight.tum";
  EXPECT_TRUE(WriteTumTrajectory(poses, spec.poses).ok());
  auto samples = std::make_shared<ImuSamples>(flight.imu());
  for (ImuSample& sample : *samples) {
    sample.timestamp_ns += kLater_ns;
    sample.specific_force_mps2 += Eigen::Vector3d(0.05, -0.1, 0.1);
  }
  spec.imu = {};
  spec.imu.file = "imu.csv";
  spec.imu.measured = samples;
  spec.around = PathSurroundings::kRoom;
  return spec;
}

TEST(ImuSequenceTest, FollowsTheFlightOfARealImuInAWorldThatIsUpright) {
  const auto flight = OpenImu(ImuSpecOf(SimulatedWorld::kFloor, FloorMotion::kFly));
  SimulationSpec spec = MeasuredFlightSpec(*flight);
  const auto again = OpenImu(spec);
  EXPECT_NEAR(CalibrationOf(*again).rate_hz, kImuRate_hz, 1e-6);
  EXPECT_EQ(again->frame_count(), 19'996u);
  EXPECT_EQ(again->imu().front().timestamp_ns, 0);
  EXPECT_EQ(again->imu()[3].angular_velocity_rps, flight->imu()[128].angular_velocity_rps);
  for (size_t i = 0; i < again->frame_count(); i += 100) {
    // The world has another heading and another origin than the one that was flown in: heights and
    // slopes are the same.
    const Rigid3d there = flight->world_from_camera(i + 500);
    const Rigid3d here = again->world_from_camera(i);
    const double climbed = (here.translation - again->world_from_camera(0).translation).y();
    EXPECT_NEAR(climbed, (there.translation - flight->world_from_camera(500).translation).y(),
                0.005);
    const Eigen::Vector3d down = here.rotation.conjugate() * Eigen::Vector3d::UnitY();
    EXPECT_LT((down - there.rotation.conjugate() * Eigen::Vector3d::UnitY()).norm(), 0.002);
  }
  spec.picture_scale = 0.2;
  const SensorImages images = *OpenImu(spec)->Render(1000);
  EXPECT_GT(cv::countNonZero(images.grey > 20), static_cast<int>(images.grey.total() / 2));
}

TEST(ImuSequenceTest, RefusesARealImuThatIsNotOfThePath) {
  const auto flight = OpenImu(ImuSpecOf(SimulatedWorld::kFloor, FloorMotion::kFly));
  const SimulationSpec good = MeasuredFlightSpec(*flight);
  const auto message = [&](const auto& change) {
    SimulationSpec spec = good;
    change(spec);
    return std::string(SimulatedSequence::Make(spec).status().message());
  };
  EXPECT_THAT(message([](SimulationSpec& spec) {
                auto late = std::make_shared<ImuSamples>(*spec.imu.measured);
                for (ImuSample& sample : *late) sample.timestamp_ns += 3'000'000'000;
                spec.imu.measured = late;
              }),
              HasSubstr("flight.tum and imu.csv: the IMU's samples are not of the poses' motion"));
  EXPECT_THAT(message([](SimulationSpec& spec) { spec.turned = true; }), HasSubstr("turned=1"));
  EXPECT_THAT(message([](SimulationSpec& spec) { spec.set_off_s = 2; }), HasSubstr("set_off_s=2"));
  EXPECT_THAT(message([](SimulationSpec& spec) { spec.imu.rate_hz = 100; }),
              HasSubstr("imu=imu.csv: wants no imu_rate"));
  EXPECT_THAT(message([](SimulationSpec& spec) { spec.moving_cars = 1; }),
              HasSubstr("around=room"));
  EXPECT_THAT(message([](SimulationSpec& spec) {
                spec.world = SimulatedWorld::kCity;
                spec.poses.clear();
                spec.around = PathSurroundings::kStreets;
              }),
              HasSubstr("imu=imu.csv: wants the world path"));
}

TEST(ImuSequenceTest, RefusesWhatNoImuMeasures) {
  const auto message = [](const SimulationSpec& spec) {
    return std::string(SimulatedSequence::Make(spec).status().message());
  };
  SimulationSpec spec = ImuSpecOf(SimulatedWorld::kCity);
  spec.kidnap = Kidnap{5, 20};
  EXPECT_THAT(message(spec), HasSubstr("kidnap=5:20: wants no imu"));
  spec.kidnap.reset();
  spec.beginning.still_s = 2;
  EXPECT_THAT(message(spec), HasSubstr("set_off_s=0: wants more than 0"));
  spec.beginning = {};
  spec.imu.vibration.amplitude.accel_mps2 = 3;
  EXPECT_THAT(message(spec), HasSubstr("imu_vibration=0:0:3: wants a frequency"));
  spec.imu.vibration = {};
  spec.imu.warming.change.accel_mps2 = 3;
  EXPECT_THAT(message(spec), HasSubstr("imu_warming=0:3:0: wants a time"));
  spec.imu.warming = {};
  spec.imu = {};
  spec.imu.late_s = 0.01;
  EXPECT_THAT(message(spec), HasSubstr("imu_late_s=0.01: wants imu="));
}

}  // namespace
}  // namespace corbslam
