#include "services/simulation/motion/drives.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "services/simulation/motion/street_tour.h"

namespace corbslam {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::Field;
using ::testing::Ge;
using ::testing::IsEmpty;
using ::testing::Le;

double TurnBetween(const Rigid3d& a, const Rigid3d& b) {
  return RotationAngle(a.rotation.conjugate() * b.rotation);
}

// Largest changes of position and of rotation from one pose to the next.
struct Jumps {
  double metres = 0;
  double radians = 0;
};
Jumps LargestJumps(const std::vector<Rigid3d>& poses) {
  Jumps jumps;
  for (size_t i = 1; i < poses.size(); ++i) {
    jumps.metres = std::max(jumps.metres, (poses[i].translation - poses[i - 1].translation).norm());
    jumps.radians = std::max(jumps.radians, TurnBetween(poses[i - 1], poses[i]));
  }
  return jumps;
}

TEST(StreetTourTest, ComesBackAndDrivesStreetsAgain) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const StreetTour tour = MakeStreetTour({.seed = seed, .length_m = 2000});
    EXPECT_NEAR(tour.length_m, 2000, 1e-6);
    EXPECT_GT(tour.repeated_m, 100) << seed;
    EXPECT_LT(tour.repeated_m, 1300) << seed;
    for (size_t i = 0; i < tour.crossings.size(); ++i) {
      const Eigen::Vector2d& next = tour.crossings[(i + 1) % tour.crossings.size()];
      const Eigen::Vector2d& after = tour.crossings[(i + 2) % tour.crossings.size()];
      EXPECT_GT((next - tour.crossings[i]).norm(), 35) << seed;
      EXPECT_GT((after - tour.crossings[i]).norm(), 35) << seed << " turns back in a street";
    }
  }
}

TEST(StreetTourTest, ShortOnesGoRoundOneBlock) {
  const StreetTour tour = MakeStreetTour({.seed = 3, .length_m = 160});
  EXPECT_EQ(tour.crossings.size(), 4u);
  EXPECT_NEAR(tour.length_m, 160, 1e-6);
  EXPECT_EQ(tour.repeated_m, 0);
}

TEST(DriveThroughTownTest, KeepsTheLawsOfDriving) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const std::vector<TravelSample> drive = PlanDriveThroughTown({.seed = seed, .length_m = 1500});
    const TravelLimits limits;
    EXPECT_THAT(drive, Each(Field(&TravelSample::speed_mps, AllOf(Ge(2.0), Le(12.0)))));
    EXPECT_THAT(drive,
                Each(Field(&TravelSample::forward_mps2, AllOf(Ge(-limits.brake_mps2 - 1e-6),
                                                              Le(limits.accelerate_mps2 + 1e-6)))));
    EXPECT_THAT(
        drive, Each(Field(&TravelSample::lateral_mps2,
                          AllOf(Ge(-limits.lateral_mps2 - 1e-6), Le(limits.lateral_mps2 + 1e-6)))));
    // The limits hold for the positions, not only for the profile.
    for (size_t i = 1; i + 1 < drive.size(); ++i) {
      const Eigen::Vector2d acceleration =
          (drive[i + 1].position - 2 * drive[i].position + drive[i - 1].position) *
          (kCarRate_hz * kCarRate_hz);
      EXPECT_LT(acceleration.norm(), 3.5) << "seed " << seed << ", sample " << i;
    }
    const auto by_speed = [](const TravelSample& a, const TravelSample& b) {
      return a.speed_mps < b.speed_mps;
    };
    const auto [slowest, fastest] = std::minmax_element(drive.begin(), drive.end(), by_speed);
    EXPECT_LT(slowest->speed_mps, 6);
    EXPECT_GT(fastest->speed_mps, 9);
  }
}

TEST(DriveThroughTownTest, BeginsAtTheOriginAndComesBackToIt) {
  const CarDriveOptions options = {.seed = 5, .length_m = 900};
  const std::vector<Rigid3d> poses = DriveThroughTown(options);
  ASSERT_GT(poses.size(), 100u);
  EXPECT_LT(poses.front().translation.norm(), 0.1);
  EXPECT_GT((poses.front().rotation * Eigen::Vector3d::UnitZ()).z(), 0.99);
  const auto closest_later =
      std::min_element(poses.begin() + 100, poses.end(), [](const Rigid3d& a, const Rigid3d& b) {
        return a.translation.norm() < b.translation.norm();
      });
  EXPECT_LT(closest_later->translation.norm(), 1.0);
  EXPECT_LT(TurnBetween(poses.front(), *closest_later), 0.05);
  // The rest is the lead-out.
  EXPECT_NEAR((poses.back().translation - closest_later->translation).norm(), 40, 5);
}

TEST(DriveThroughTownTest, IsSmoothAndLooksAhead) {
  const std::vector<Rigid3d> poses = DriveThroughTown({.seed = 2, .length_m = 1200});
  const Jumps jumps = LargestJumps(poses);
  EXPECT_LT(jumps.metres, 1.25);
  EXPECT_LT(jumps.radians, 0.09);
  for (size_t i = 1; i + 1 < poses.size(); ++i) {
    const Eigen::Vector3d way = (poses[i + 1].translation - poses[i - 1].translation).normalized();
    EXPECT_GT(way.dot(poses[i].rotation * Eigen::Vector3d::UnitZ()), 0.99) << i;
    // The camera is upright when its y points down.
    EXPECT_GT((poses[i].rotation * Eigen::Vector3d::UnitY()).y(), 0.99) << i;
  }
}

TEST(DriveThroughTownTest, SeedsGiveOtherDrives) {
  const std::vector<Rigid3d> one = DriveThroughTown({.seed = 1, .length_m = 600});
  const std::vector<Rigid3d> same = DriveThroughTown({.seed = 1, .length_m = 600});
  const std::vector<Rigid3d> other = DriveThroughTown({.seed = 2, .length_m = 600});
  ASSERT_EQ(one.size(), same.size());
  EXPECT_EQ(one.back().translation, same.back().translation);
  EXPECT_GT((one[300].translation - other[300].translation).norm(), 0.5);
}

// The way is walked back again.
const std::vector<Eigen::Vector2d> kRooms = {{0, 0}, {0, 8}, {6, 8}, {6, 11},
                                             {6, 8}, {0, 8}, {0, 0}};

TEST(WalkAlongTest, IsSmoothWhereTheWalkerTurnsBack) {
  const std::vector<Rigid3d> poses = WalkAlong(kRooms, 4);
  ASSERT_GT(poses.size(), 600u);
  const Jumps jumps = LargestJumps(poses);
  EXPECT_LT(jumps.metres, 1.5 / kWalkerRate_hz);
  EXPECT_LT(jumps.radians, 2.0 / kWalkerRate_hz);
  for (const Rigid3d& pose : poses) EXPECT_NEAR(pose.translation.y(), -1.5, 0.05);
}

TEST(WalkAlongTest, StaysNearTheWay) {
  const std::vector<Rigid3d> poses = WalkAlong({{0, 0}, {0, 8}, {6, 8}}, 4);
  for (const Rigid3d& pose : poses) {
    const double x = pose.translation.x();
    const double z = pose.translation.z();
    EXPECT_LT(std::min(std::abs(x), std::abs(z - 8)), 0.25);
  }
}

TEST(FlyAlongTest, IsSmoothAndMovesInAllDirections) {
  const std::vector<Rigid3d> poses = FlyAlong(kRooms, 4);
  ASSERT_GT(poses.size(), 300u);
  const Jumps jumps = LargestJumps(poses);
  EXPECT_LT(jumps.metres, 1.9 / kDroneRate_hz);
  EXPECT_LT(jumps.radians, 2.0 / kDroneRate_hz);
  double lowest = 10;
  double highest = 0;
  double most_roll = 0;
  for (const Rigid3d& pose : poses) {
    lowest = std::min(lowest, -pose.translation.y());
    highest = std::max(highest, -pose.translation.y());
    most_roll = std::max(most_roll, std::abs((pose.rotation * Eigen::Vector3d::UnitX()).y()));
  }
  EXPECT_GT(highest - lowest, 0.2);
  EXPECT_GE(lowest, 0.9);
  EXPECT_LE(highest, 1.9);
  EXPECT_GT(most_roll, 0.02);
}

TEST(DrivesTest, NoWayNoPoses) {
  EXPECT_THAT(WalkAlong({}, 1), IsEmpty());
  EXPECT_THAT(WalkAlong({{1, 1}, {1, 1}}, 1), IsEmpty());
  EXPECT_THAT(FlyAlong({{2, 3}}, 1), IsEmpty());
}

}  // namespace
}  // namespace corbslam
