#include "services/simulation/worlds/floor_world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "services/simulation/worlds/floor_plan.h"

namespace corbslam {
namespace {

using Eigen::Vector2d;

double DistanceToLine(const Vector2d& from, const Vector2d& to, const Vector2d& at) {
  const Vector2d way = to - from;
  const double share =
      way.squaredNorm() > 0 ? std::clamp((at - from).dot(way) / way.squaredNorm(), 0.0, 1.0) : 0;
  return (from + share * way - at).norm();
}

// Returns the distance to the nearest piece of furniture or wall, but for the open doorways.
double Clearance(const FloorPlan& plan, const Vector2d& at) {
  double nearest = 100;
  for (const Furniture& piece : plan.furniture) {
    const Vector2d out =
        (piece.footprint.low - at).cwiseMax(at - piece.footprint.high).cwiseMax(0.0);
    nearest = std::min(nearest, out.norm());
  }
  for (const Wall& wall : plan.walls) {
    if (wall.doorway) continue;
    nearest = std::min(nearest, DistanceToLine(wall.from, wall.to, at) - kWallM / 2);
  }
  return nearest;
}

TEST(FloorWorld, TheTourMeetsNothing) {
  for (const bool look_alike : {false, true}) {
    for (uint64_t seed = 1; seed <= 5; ++seed) {
      const FloorPlan plan = MakeFloorPlan({.seed = seed, .look_alike_corridors = look_alike});
      EXPECT_GT(plan.furniture.size(), 60U);
      const std::vector<Vector2d> tour = TourOfFloor(plan, seed);
      ASSERT_GT(tour.size(), 10U);
      for (size_t i = 0; i + 1 < tour.size(); ++i) {
        const double length = (tour[i + 1] - tour[i]).norm();
        ASSERT_GT(length, 0) << i;
        for (double way = 0; way < length; way += 0.1) {
          const Vector2d at = tour[i] + way / length * (tour[i + 1] - tour[i]);
          ASSERT_GT(Clearance(plan, at), kFloorClearanceM) << "seed " << seed << " leg " << i;
        }
      }
    }
  }
}

TEST(FloorWorld, TheTourComesBackAndSeesEveryRow) {
  const FloorPlan plan = MakeFloorPlan({.seed = 3});
  const std::vector<Vector2d> tour = TourOfFloor(plan, 3);
  int at_start = 0;
  for (const Vector2d& at : tour) at_start += (at - tour.front()).norm() < 1e-9;
  EXPECT_GE(at_start, 2);
  for (int corridor = 0; corridor <= plan.options.rooms_z; ++corridor) {
    const double z = Middle(plan.corridors[static_cast<size_t>(corridor)]).y();
    EXPECT_TRUE(std::any_of(tour.begin(), tour.end(), [&](const Vector2d& at) {
      return std::abs(at.y() - z) < 1e-9;
    })) << corridor;
  }
  int rooms = 0;
  for (const FloorBox& room : plan.rooms) {
    rooms += std::any_of(tour.begin(), tour.end(),
                         [&](const Vector2d& at) { return (at - Middle(room)).norm() < 1e-9; });
  }
  EXPECT_GE(rooms, plan.options.rooms_z);
}

TEST(FloorWorld, FollowsTheSeed) {
  const auto corners = [](uint64_t seed) {
    std::vector<float> numbers;
    const Scene scene = BuildFloorScene(MakeFloorPlan({.seed = seed}));
    for (const Mesh& mesh : scene.meshes) {
      for (const Patch& patch : mesh.patches) {
        for (const auto& corner : patch.corners) {
          numbers.insert(numbers.end(), {corner.x(), corner.y(), corner.z()});
        }
        numbers.push_back(static_cast<float>(patch.seed));
      }
    }
    return numbers;
  };
  EXPECT_EQ(corners(1), corners(1));
  EXPECT_NE(corners(1), corners(2));
}

// Returns a corridor's furniture relative to its corner.
std::vector<std::array<double, 4>> FurnitureOf(const FloorPlan& plan, int corridor) {
  const FloorBox& box = plan.corridors[static_cast<size_t>(corridor)];
  std::vector<std::array<double, 4>> pieces;
  for (const Furniture& piece : plan.furniture) {
    const Vector2d at = Middle(piece.footprint);
    if ((at - box.low).minCoeff() < 0 || (box.high - at).minCoeff() < 0) continue;
    // The corridors along z are skipped.
    if (at.x() < 2.5 || at.x() > box.high.x() - 2.5) continue;
    pieces.push_back(
        {at.x(), at.y() - box.low.y(), piece.height_m, static_cast<double>(piece.seed)});
  }
  return pieces;
}

TEST(FloorWorld, LookAlikeCorridorsDoLookAlike) {
  const FloorPlan plan = MakeFloorPlan({.seed = 4, .look_alike_corridors = true});
  const auto second = FurnitureOf(plan, 1);
  const auto third = FurnitureOf(plan, 2);
  ASSERT_GT(second.size(), 2U);
  ASSERT_EQ(second.size(), third.size());
  for (size_t i = 0; i < second.size(); ++i) {
    for (size_t k = 0; k < 4; ++k) EXPECT_NEAR(second[i][k], third[i][k], 1e-9);
  }
  EXPECT_NE(FurnitureOf(plan, 0), second);
  const FloorPlan own = MakeFloorPlan({.seed = 4});
  EXPECT_NE(FurnitureOf(own, 1), FurnitureOf(own, 2));
}

TEST(FloorWorld, CountsBelowOneAreOne) {
  const FloorPlan plan = MakeFloorPlan({.seed = 1, .rooms_x = 0, .rooms_z = -3});
  EXPECT_EQ(plan.rooms.size(), 1U);
  EXPECT_EQ(plan.corridors.size(), 4U);
  EXPECT_GT(TourOfFloor(plan, 1).size(), 5U);
}

}  // namespace
}  // namespace corbslam
