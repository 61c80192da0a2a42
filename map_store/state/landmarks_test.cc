#include "map_store/state/landmarks.h"

#include <gtest/gtest.h>

namespace corbslam::map_store {
namespace {

constexpr MapPointId A(uint32_t index) { return {{0xa}, index}; }
constexpr MapPointId B(uint32_t index) { return {{0xb}, index}; }

TEST(LandmarksTest, LonePointsStandForThemselves) {
  Landmarks landmarks;
  EXPECT_EQ(landmarks.Survivor(A(1)), A(1));
  EXPECT_TRUE(landmarks.sets().empty());
}

TEST(LandmarksTest, MergingSetsKeepsTheFirstSurvivor) {
  Landmarks landmarks;
  landmarks.Merge(A(1), B(1));
  landmarks.Merge(A(2), B(2));
  // The points that are named need not be survivors: their whole sets are merged.
  EXPECT_EQ(landmarks.Merge(B(1), B(2)), A(1));
  for (const MapPointId& id : {A(1), A(2), B(1), B(2)}) EXPECT_EQ(landmarks.Survivor(id), A(1));
  EXPECT_EQ(landmarks.sets().at(A(1)), (std::set<MapPointId>{A(2), B(1), B(2)}));
  // A second merging changes nothing, whatever the order.
  EXPECT_EQ(landmarks.Merge(B(2), A(1)), A(1));
  EXPECT_EQ(landmarks.sets().size(), 1u);
}

TEST(LandmarksTest, RemovingTheSurvivorElectsAnother) {
  Landmarks landmarks;
  landmarks.Merge(A(1), B(1));
  landmarks.Merge(A(1), B(2));
  EXPECT_EQ(landmarks.Remove(A(1)), B(1));
  EXPECT_EQ(landmarks.Survivor(B(2)), B(1));
  EXPECT_EQ(landmarks.Remove(B(2)), B(1));
  EXPECT_TRUE(landmarks.sets().empty());
  EXPECT_FALSE(landmarks.Remove(B(1)).IsValid());
}

TEST(LandmarksTest, AReplacementTakesThePlaceInTheSet) {
  Landmarks landmarks;
  landmarks.Merge(A(1), B(1));
  EXPECT_EQ(landmarks.Replace(B(1), B(5)), A(1));
  EXPECT_EQ(landmarks.Survivor(B(5)), A(1));
  EXPECT_EQ(landmarks.Survivor(B(1)), B(1)) << "is out of it";
  // The survivor is replaced: another point is elected, and the replacement becomes a member.
  EXPECT_EQ(landmarks.Replace(A(1), A(7)), B(5));
  EXPECT_EQ(landmarks.Survivor(A(7)), B(5));
  // The point that is replaced is in no set.
  EXPECT_EQ(landmarks.Replace(A(3), A(7)), B(5));
  EXPECT_EQ(landmarks.sets().size(), 1u);
}

}  // namespace
}  // namespace corbslam::map_store
