#include "map_store/state/point_index.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::map_store {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

constexpr LocalMapId kA{0xa};
constexpr LocalMapId kB{0xb};
constexpr MapPointId Pa(uint32_t index) { return {kA, index}; }
constexpr KeyframeId Kb(uint32_t index) { return {kB, index}; }

TEST(PointIndexTest, KnowsWhoSeesAPoint) {
  PointIndex index;
  index.AddViewer(Pa(1), Kb(1), 10);
  index.AddViewer(Pa(1), Kb(2), 20);
  index.AddViewer(Pa(2), Kb(1), 30);
  EXPECT_THAT(index.ViewersOf(Pa(1)), ElementsAre(Kb(1), Kb(2)));
  index.RemoveViewer(Pa(1), Kb(1), 10);
  index.RemoveViewer(Pa(1), Kb(7), 10);
  index.RemoveViewer(Pa(9), Kb(1), 10);
  EXPECT_THAT(index.ViewersOf(Pa(1)), ElementsAre(Kb(2)));
  index.RemoveViewer(Pa(1), Kb(2), 20);
  EXPECT_THAT(index.ViewersOf(Pa(1)), IsEmpty());
  EXPECT_THAT(index.ViewersOf(Pa(2)), ElementsAre(Kb(1)));
}

TEST(PointIndexTest, KnowsByWhichKeypoint) {
  PointIndex index;
  index.AddViewer(Pa(1), Kb(1), 10);
  index.AddViewer(Pa(1), Kb(1), 11);
  EXPECT_EQ(index.FindSight(Pa(1), Kb(1)), 10);
  index.RemoveViewer(Pa(1), Kb(1), 11);
  EXPECT_EQ(index.FindSight(Pa(1), Kb(1)), 10);
  index.RemoveViewer(Pa(1), Kb(1), 10);
  EXPECT_EQ(index.FindSight(Pa(1), Kb(1)), std::nullopt);
  EXPECT_EQ(index.FindSight(Pa(2), Kb(1)), std::nullopt);
}

TEST(PointIndexTest, KnowsAllNamesThatAPointHas) {
  PointIndex index;
  index.NoteReplaced(Pa(1), Pa(2));
  index.NoteReplaced(Pa(2), Pa(3));
  index.NoteReplaced(Pa(4), Pa(3));
  EXPECT_THAT(index.NamesOf(Pa(3)), UnorderedElementsAre(Pa(1), Pa(2), Pa(3), Pa(4)));
  EXPECT_THAT(index.NamesOf(Pa(2)), UnorderedElementsAre(Pa(1), Pa(2)));
  EXPECT_THAT(index.NamesOf(Pa(9)), ElementsAre(Pa(9)));
}

TEST(PointIndexTest, NamesInACircleEnd) {
  PointIndex index;
  index.NoteReplaced(Pa(1), Pa(2));
  index.NoteReplaced(Pa(2), Pa(1));
  EXPECT_THAT(index.NamesOf(Pa(1)), UnorderedElementsAre(Pa(1), Pa(2)));
}

}  // namespace
}  // namespace corbslam::map_store
