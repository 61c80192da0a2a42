#include "services/programs/robot/relocalisation_count.h"

#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using client_agent::TrackingResult;
using client_agent::TrackingState;

TrackingResult Tracked(uint64_t local_map, int points, int others) {
  TrackingResult result;
  result.state = TrackingState::kTracking;
  result.local_map = LocalMapId{local_map};
  result.points_matched = points;
  result.foreign_points_matched = others;
  return result;
}

TrackingResult Lost() {
  TrackingResult result;
  result.state = TrackingState::kLost;
  return result;
}

TEST(RelocalisationCountTest, CountsFramesThatAreFoundAgainInTheSameMap) {
  RelocalisationCount count;
  for (const TrackingResult& result :
       {Tracked(1, 100, 0), Lost(), Lost(), Tracked(1, 100, 50), Tracked(1, 100, 90)}) {
    count.Add(result);
  }
  EXPECT_EQ(count.all(), 1);
  EXPECT_EQ(count.by_others(), 0) << "half of the points are its own";
  count.Add(Lost());
  count.Add(Tracked(1, 100, 51));
  EXPECT_EQ(count.all(), 2);
  EXPECT_EQ(count.by_others(), 1);
}

TEST(RelocalisationCountTest, ANewLocalMapIsNoPlaceFoundAgain) {
  RelocalisationCount count;
  // The first pose of all comes behind frames without one.
  for (const TrackingResult& result : {Lost(), Tracked(1, 100, 0), Lost(), Tracked(2, 100, 100)}) {
    count.Add(result);
  }
  EXPECT_EQ(count.all(), 0);
  EXPECT_EQ(count.by_others(), 0);
}

}  // namespace
}  // namespace corbslam::services
