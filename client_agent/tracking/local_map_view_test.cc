#include "client_agent/tracking/local_map_view.h"

#include <gtest/gtest.h>

#include <iterator>
#include <utility>
#include <vector>

#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam::client_agent {
namespace {

TEST(GatherLocalMapTest, OthersPointsThatNoTwoOwnKeyframesSeeAreHearsay) {
  const testing::SyntheticScene scene = testing::MakeSyntheticScene({});
  Map map = scene.map;
  const LocalMapId own = map.keyframes().begin()->first.local_map;
  const KeyframeId first = map.keyframes().begin()->first;
  const KeyframeId second = std::next(map.keyframes().begin())->first;
  const MapPointId hearsay{{77}, 1};
  const MapPointId located{{77}, 2};
  std::vector<MapPointId> of_both;
  for (const MapPointId id : map.FindKeyframe(first)->points) {
    if (id.IsValid() && map.FindPoint(id)->observations.contains(second)) of_both.push_back(id);
  }
  ASSERT_GE(of_both.size(), 2u);
  for (const auto& [id, replaced] :
       {std::pair(hearsay, of_both[0]), std::pair(located, of_both[1])}) {
    MapPoint point;
    point.id = id;
    point.position_in_map = map.FindPoint(replaced)->position_in_map;
    map.AddPoint(point);
    ASSERT_TRUE(map.ReplacePoint(replaced, id));
    map.UpdatePointAppearance(id);
  }
  const auto observations = map.FindPoint(hearsay)->observations;
  for (const auto& [keyframe, index] : observations) {
    if (keyframe != first) map.RemoveObservation(hearsay, keyframe);
  }
  const Keyframe& keyframe = *map.FindKeyframe(first);
  const LocalMapView view = GatherLocalMap(map, own, {hearsay, located}, first, keyframe.camera(),
                                           keyframe.camera_from_map);
  EXPECT_EQ(view.hearsay.size(), 1u);
  EXPECT_TRUE(view.hearsay.contains(hearsay));
}

}  // namespace
}  // namespace corbslam::client_agent
