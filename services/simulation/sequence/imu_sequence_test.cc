#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <numbers>
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

SimulationSpec SpecOf(SimulatedWorld world, FloorMotion motion = FloorMotion::kWalk) {
  SimulationSpec spec;
  spec.world = world;
  spec.motion = motion;
  spec.seed = 3;
  spec.length_m = 400;
  spec.rate_hz = kTruthRate_hz;
  spec.imu.grade = ImuGrade::kIdeal;
  return spec;
}

std::unique_ptr<SimulatedSequence> Open(const SimulationSpec& spec) {
  absl::StatusOr<std::unique_ptr<SimulatedSequence>> sequence = SimulatedSequence::Make(spec);
  EXPECT_TRUE(sequence.ok()) << sequence.status();
  return *std::move(sequence);
}

ImuCalibration CalibrationOf(const SimulatedSequence& sequence) {
  return *std::visit([](const auto& sensor) { return sensor.imu; }, sequence.calibration());
}

// What integrating the samples gives: by the mean of two neighbours, from the true pose and
// velocity of the first.
struct State {
  Rigid3d world_from_imu;
  Eigen::Vector3d velocity_mps;
};

void Step(const ImuSample& from, const ImuSample& to, State& state) {
  const Eigen::Vector3d gravity(0, kGravity_mps2, 0);
  const double step_s = 1e-9 * static_cast<double>(to.timestamp_ns - from.timestamp_ns);
  const Eigen::Quaterniond before = state.world_from_imu.rotation;
  const Eigen::Quaterniond after =
      (before * ExpSO3(0.5 * step_s * (from.angular_velocity_rps + to.angular_velocity_rps)))
          .normalized();
  const Eigen::Vector3d first = before * from.specific_force_mps2 + gravity;
  const Eigen::Vector3d second = after * to.specific_force_mps2 + gravity;
  state.world_from_imu.translation +=
      step_s * state.velocity_mps + step_s * step_s / 6 * (2 * first + second);
  state.velocity_mps += 0.5 * step_s * (first + second);
  state.world_from_imu.rotation = after;
}

struct Drift {
  double metres = 0;
  double degrees = 0;
};

// Returns how far from the truth ten seconds of samples end, from `from_s` on.
Drift DriftOf(const SimulatedSequence& sequence, double from_s) {
  const Rigid3d camera_from_imu = CalibrationOf(sequence).imu_from_camera.Inverse();
  const auto truth = [&](int64_t time_ns) {
    return sequence.world_from_camera(static_cast<size_t>(time_ns / 1'000'000)) * camera_from_imu;
  };
  const auto begin_ns = std::llround(1e9 * from_s);
  const int64_t end_ns = begin_ns + 10'000'000'000;
  State state;
  state.world_from_imu = truth(begin_ns);
  state.velocity_mps =
      (truth(begin_ns + 1'000'000).translation - truth(begin_ns - 1'000'000).translation) / 2e-3;
  const ImuSample* last = nullptr;
  for (const ImuSample& sample : sequence.imu()) {
    if (sample.timestamp_ns < begin_ns || sample.timestamp_ns > end_ns) continue;
    if (last != nullptr) Step(*last, sample, state);
    last = &sample;
  }
  EXPECT_EQ(last->timestamp_ns, end_ns);
  const Rigid3d end = truth(end_ns);
  return {(state.world_from_imu.translation - end.translation).norm(),
          RotationAngle(state.world_from_imu.rotation.conjugate() * end.rotation) * 180 /
              std::numbers::pi};
}

void ExpectNoDrift(const SimulationSpec& spec, const std::string& name) {
  const auto sequence = Open(spec);
  double metres = 0;
  double degrees = 0;
  for (double from_s = 0.5; from_s + 11 < 1e-3 * static_cast<double>(sequence->frame_count());
       from_s += 5) {
    const Drift drift = DriftOf(*sequence, from_s);
    metres = std::max(metres, drift.metres);
    degrees = std::max(degrees, drift.degrees);
  }
  EXPECT_GT(metres, 0) << name;  // There were ten seconds to look at.
  EXPECT_LT(metres, 0.01) << name;
  EXPECT_LT(degrees, 0.01) << name;
  std::cout << name << ": at most " << 1e3 * metres << " mm and " << degrees
            << " degrees after 10 s\n";
}

TEST(ImuSequenceTest, IntegratesToTheTruthInEachWorld) {
  ExpectNoDrift(SpecOf(SimulatedWorld::kCity), "city");
  ExpectNoDrift(SpecOf(SimulatedWorld::kFloor), "walk");
  ExpectNoDrift(SpecOf(SimulatedWorld::kFloor, FloorMotion::kFly), "fly");
  SimulationSpec path = SpecOf(SimulatedWorld::kPath);
  path.poses = ::testing::TempDir() + "/imu_poses.txt";
  Trajectory poses;
  for (const Rigid3d& pose : DriveThroughTown({.seed = 5, .length_m = 400})) {
    poses.push_back({static_cast<int64_t>(poses.size()) * 100'000'000, pose});
  }
  ASSERT_TRUE(WriteKittiTrajectory(poses, path.poses).ok());
  ExpectNoDrift(path, "path");
}

TEST(ImuSequenceTest, IntegratesToTheTruthTurnedLaterAndFromAStand) {
  SimulationSpec turned = SpecOf(SimulatedWorld::kFloor);
  turned.turned = true;
  turned.phase = 0;
  ExpectNoDrift(turned, "turned");
  SimulationSpec standing = SpecOf(SimulatedWorld::kCity);
  standing.beginning = {1, 0, 1};
  standing.set_off_s = 3;
  ExpectNoDrift(standing, "from a stand");
  standing.turned = true;
  ExpectNoDrift(standing, "turned, from a stand");
  SimulationSpec fast = SpecOf(SimulatedWorld::kFloor, FloorMotion::kFly);
  fast.imu.rate_hz = 1000;
  ExpectNoDrift(fast, "1000 a second");
}

TEST(ImuSequenceTest, StandsBeforeItSetsOff) {
  SimulationSpec spec = SpecOf(SimulatedWorld::kFloor);
  spec.beginning = {1, 1, 1};
  spec.set_off_s = 2;
  spec.start_s = 100;
  const auto sequence = Open(spec);
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
  SimulationSpec spec = SpecOf(SimulatedWorld::kCity);
  spec.imu = {};
  const auto without = Open(spec);
  EXPECT_TRUE(without->imu().empty());
  EXPECT_FALSE(std::get<StereoCalibration>(without->calibration()).imu.has_value());
}

TEST(ImuSequenceTest, IsOfTheTimesAndThePosesThatThePicturesHave) {
  SimulationSpec spec = SpecOf(SimulatedWorld::kCity);
  spec.imu = {};
  const auto without = Open(spec);
  spec.imu.grade = ImuGrade::kGood;
  const auto with = Open(spec);
  ASSERT_EQ(with->frame_count(), without->frame_count());
  for (size_t i = 0; i < with->frame_count(); i += 97) {
    EXPECT_EQ(with->timestamp_ns(i), without->timestamp_ns(i));
    EXPECT_EQ(with->world_from_camera(i).translation, without->world_from_camera(i).translation);
  }
  const int64_t end_ns = with->timestamp_ns(with->frame_count() - 1);
  EXPECT_EQ(with->imu().front().timestamp_ns, 0);
  EXPECT_NEAR(1e-9 * static_cast<double>(with->imu().back().timestamp_ns - end_ns), 0, 0.005);
  EXPECT_EQ(CalibrationOf(*with).rate_hz, 200);
  EXPECT_EQ(CalibrationOf(*with).noise.gyro, NoiseOf(ImuGrade::kGood).gyro);
  EXPECT_EQ(CalibrationOf(*with).time_offset_s, 0);
}

TEST(ImuSequenceTest, NoiseIsOfTheNoiseSeedAloneWhoeverAsks) {
  SimulationSpec spec = SpecOf(SimulatedWorld::kFloor);
  spec.imu.grade = ImuGrade::kPhone;
  const auto first = Open(spec);
  spec.threads = 3;
  const auto second = Open(spec);
  std::thread other([&] { EXPECT_FALSE(second->imu().empty()); });
  EXPECT_FALSE(second->imu().empty());
  other.join();
  ASSERT_EQ(first->imu().size(), second->imu().size());
  for (size_t i = 0; i < first->imu().size(); ++i) {
    EXPECT_EQ(first->imu()[i].specific_force_mps2, second->imu()[i].specific_force_mps2);
  }
  spec.lens.noise_seed = 2;
  EXPECT_NE(Open(spec)->imu()[7].specific_force_mps2, first->imu()[7].specific_force_mps2);
}

TEST(ImuSequenceTest, ARigSaysWhereItsImuSits) {
  SimulationSpec spec = SpecOf(SimulatedWorld::kCity);
  spec.imu = {};
  SimulatedPair& pair = spec.pair.emplace();
  pair.width_px = 64;
  pair.height_px = 48;
  pair.left.fx_px = pair.left.fy_px = pair.right.fx_px = pair.right.fy_px = 40;
  pair.told.imu.emplace().imu_from_camera.translation = {0.5, 0, 0};
  EXPECT_FALSE(std::get<StereoCalibration>(Open(spec)->calibration()).imu.has_value());
  spec.imu.grade = ImuGrade::kIdeal;
  const auto sequence = Open(spec);
  EXPECT_EQ(CalibrationOf(*sequence).imu_from_camera.translation.x(), 0.5);
  EXPECT_LT(DriftOf(*sequence, 1).metres, 0.01);
}

TEST(ImuSequenceTest, RefusesWhatNoImuMeasures) {
  const auto message = [](const SimulationSpec& spec) {
    return std::string(SimulatedSequence::Make(spec).status().message());
  };
  SimulationSpec spec = SpecOf(SimulatedWorld::kCity);
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
  spec.imu.grade.reset();
  spec.imu.late_s = 0.01;
  EXPECT_THAT(message(spec), HasSubstr("imu_late_s=0.01: wants imu="));
}

}  // namespace
}  // namespace corbslam
