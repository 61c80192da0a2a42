#include "map_store/state/far_keyframes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <vector>

namespace corbslam::map_store {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr KeyframeId Kf(uint32_t index) { return {LocalMapId{0xa}, index}; }

TEST(FarKeyframesTest, AreDueOnceTheRobotMayHaveReachedThem) {
  FarKeyframes far;
  far.MoveTo({100, 0, 0});
  far.Add(Kf(1), 5);
  far.Add(Kf(2), 3);
  EXPECT_THAT(far.TakeDue(), IsEmpty()) << "where it was first is no way";
  far.MoveTo({102.9, 0, 0});
  EXPECT_THAT(far.TakeDue(), IsEmpty());
  far.MoveTo({102.8, 0, 0});
  EXPECT_THAT(far.TakeDue(), ElementsAre(Kf(2))) << "the way back counts, too";
  far.MoveTo({110, 0, 0});
  EXPECT_THAT(far.TakeDue(), ElementsAre(Kf(1)));
  EXPECT_EQ(far.size(), 0u);
}

TEST(FarKeyframesTest, HaveTheDistanceThatWasSaidLast) {
  FarKeyframes far;
  far.MoveTo({0, 0, 0});
  far.Add(Kf(1), 1);
  far.Add(Kf(1), 10);
  far.Add(Kf(2), 1);
  far.Erase(Kf(2));
  far.Erase(Kf(3));
  EXPECT_EQ(far.size(), 1u);
  far.MoveTo({0, 5, 0});
  EXPECT_THAT(far.TakeDue(), IsEmpty());
  far.Add(Kf(4), 0);
  EXPECT_THAT(far.TakeDue(), ElementsAre(Kf(4)));
  EXPECT_THAT(far.TakeAll(), ElementsAre(Kf(1)));
  EXPECT_EQ(far.size(), 0u);
  far.MoveTo({0, 50, 0});
  EXPECT_THAT(far.TakeDue(), IsEmpty());
}

// A robot wanders among 10,000 keyframes: none within its reach is missed, and few are looked at.
TEST(FarKeyframesTest, FindAllThatAreWithinReachByFewLooks) {
  constexpr double kReach_m = 10;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-200, 200);
  std::uniform_real_distribution<double> turn(-0.3, 0.3);
  std::vector<Eigen::Vector3d> places(10'000);
  for (Eigen::Vector3d& at : places) at = {place(random), place(random), 0};
  FarKeyframes far;
  std::set<KeyframeId> reached;
  Eigen::Vector3d robot(0, 0, 0);
  size_t visited = 0;
  const auto visit = [&](KeyframeId id) {
    ++visited;
    const double distance_m = (places[id.index] - robot).norm();
    if (distance_m <= kReach_m) {
      reached.insert(id);
    } else {
      far.Add(id, distance_m - kReach_m);
    }
  };
  far.MoveTo(robot);
  for (uint32_t i = 0; i < places.size(); ++i) visit(Kf(i));
  double heading = 0;
  constexpr size_t kSteps = 300;
  for (size_t step = 0; step < kSteps; ++step) {
    heading += turn(random);
    robot += 0.5 * Eigen::Vector3d(std::cos(heading), std::sin(heading), 0);
    far.MoveTo(robot);
    for (const KeyframeId id : far.TakeDue()) visit(id);
    for (uint32_t i = 0; i < places.size(); ++i) {
      if ((places[i] - robot).norm() > kReach_m) continue;
      EXPECT_TRUE(reached.contains(Kf(i))) << step << " " << i;
    }
  }
  EXPECT_EQ(reached.size() + far.size(), places.size());
  EXPECT_GT(reached.size(), 30u);
  EXPECT_LT(visited - places.size(), kSteps * places.size() / 50);
}

}  // namespace
}  // namespace corbslam::map_store
