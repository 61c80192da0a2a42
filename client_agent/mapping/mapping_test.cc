// Tests the mapper and its parts on synthetic scenes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>

#include "client_agent/map/provisional_keyframes.h"
#include "client_agent/mapping/culling.h"
#include "client_agent/mapping/keyframe_insertion.h"
#include "client_agent/mapping/mapper.h"
#include "client_agent/mapping/nearest_keypoints.h"
#include "client_agent/mapping/point_creation.h"
#include "client_agent/mapping/point_fusion.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam::client_agent {
namespace {

constexpr LocalMapId kOwn{0x5ce7e};

// Makes words that put all keypoints under one node.
std::shared_ptr<const Words> OneNode(size_t keypoints) {
  auto words = std::make_shared<Words>();
  words->direct_index.emplace_back();
  for (uint32_t i = 0; i < keypoints; ++i) words->direct_index[0].features.push_back(i);
  return words;
}

class MappingTest : public ::testing::Test {
 protected:
  explicit MappingTest(testing::SyntheticSceneOptions options = DefaultScene())
      : scene_(testing::MakeSyntheticScene(options)), map_(kOwn) {}

  static testing::SyntheticSceneOptions DefaultScene() {
    testing::SyntheticSceneOptions options;
    options.keyframes = 8;
    options.points = 600;
    options.pixel_noise_px = 0.3;
    return options;
  }

  // Makes what tracking would hand over: the scene's keyframe, seen from `pose`, without points.
  NewKeyframe Handed(uint32_t index, const Rigid3d& camera_from_map) const {
    const Keyframe& seen = *scene_.map.FindKeyframe({kOwn, index});
    NewKeyframe keyframe;
    keyframe.payload = seen.payload;
    keyframe.words = OneNode(seen.keypoints().size());
    keyframe.points.resize(seen.keypoints().size());
    keyframe.camera_from_reference = camera_from_map;
    if (index > 0) {
      keyframe.reference = {kOwn, index - 1};
      keyframe.camera_from_reference =
          camera_from_map * scene_.true_camera_from_map.at(keyframe.reference).Inverse();
    }
    return keyframe;
  }

  NewKeyframe Handed(uint32_t index) const {
    return Handed(index, scene_.true_camera_from_map.at({kOwn, index}));
  }

  // Lets the keypoints of a keyframe to be see the map points that stand for the scene's.
  void SeeMapPoints(NewKeyframe& keyframe) const {
    map_.Read([&](const Map& map) {
      const std::vector<MapPointId>& seen = scene_.map.FindKeyframe(keyframe.payload->id)->points;
      for (size_t i = 0; i < seen.size(); ++i) {
        const MapPoint* point = scene_.map.FindPoint(seen[i]);
        if (point == nullptr) continue;
        for (const auto& [id, keypoint] : point->observations) {
          const Keyframe* earlier = map.FindKeyframe(id);
          if (earlier != nullptr && earlier->points[keypoint].IsValid()) {
            keyframe.points[i] = earlier->points[keypoint];
          }
        }
      }
    });
  }

  size_t CountPoints() const {
    return map_.Read([](const Map& map) { return map.points().size(); });
  }

  testing::SyntheticScene scene_;
  GuardedMap map_;
  MappingQueue queue_;
  PointStatistics statistics_;
};

TEST_F(MappingTest, InsertedKeyframeMakesPointsOfItsClosePixels) {
  const auto made = InsertKeyframe(Handed(0), map_);
  EXPECT_GE(made.size(), 100u);
  map_.Read([&](const Map& map) {
    for (const MapPointId id : made) {
      const MapPoint& point = *map.FindPoint(id);
      EXPECT_EQ(point.reference, (KeyframeId{kOwn, 0}));
      EXPECT_GT(point.max_distance, point.min_distance);
      EXPECT_NEAR(point.normal_in_map.norm(), 1, 1e-9);
    }
  });
}

TEST_F(MappingTest, InsertedKeyframeFollowsAReferenceThatMovedMeanwhile) {
  InsertKeyframe(Handed(0), map_);
  const Rigid3d shift{Eigen::Quaterniond::Identity(), {0.5, 0, 0}};
  const Rigid3d moved = scene_.true_camera_from_map.at({kOwn, 0}) * shift;
  map_.Write([&](Map& map) { map.SetPose({kOwn, 0}, moved); });
  const NewKeyframe second = Handed(1);
  InsertKeyframe(second, map_);
  const Rigid3d expected = second.camera_from_reference * moved;
  map_.Read([&](const Map& map) {
    const Keyframe& keyframe = *map.FindKeyframe({kOwn, 1});
    EXPECT_LT((keyframe.camera_from_map.translation - expected.translation).norm(), 1e-9);
    EXPECT_EQ(keyframe.parent, (KeyframeId{kOwn, 0}));
  });
}

TEST_F(MappingTest, NearestKeypointsTakesAllCloseOnesAndFillsUp) {
  Camera camera = testing::SyntheticCamera();
  camera.close_depth_m = 5;
  std::vector<Keypoint> keypoints(10);
  for (size_t i = 0; i < 10; ++i) {
    keypoints[i].disparity_px =
        static_cast<float>(DisparityFromDepth(camera, static_cast<double>(i) + 0.5));
  }
  keypoints[2].disparity_px = 0;
  EXPECT_EQ(NearestKeypoints(camera, keypoints, 0), (std::vector<uint32_t>{0, 1, 3, 4}));
  EXPECT_EQ(NearestKeypoints(camera, keypoints, 6).size(), 6u);
  EXPECT_EQ(NearestKeypoints(camera, keypoints, 100).size(), 9u);
}

TEST_F(MappingTest, TriangulatedPointsAreWhereTheyShouldBe) {
  const Keyframe& a = *scene_.map.FindKeyframe({kOwn, 0});
  const Keyframe& b = *scene_.map.FindKeyframe({kOwn, 2});
  Keyframe true_a = a;
  Keyframe true_b = b;
  true_a.camera_from_map = scene_.true_camera_from_map.at(a.id());
  true_b.camera_from_map = scene_.true_camera_from_map.at(b.id());
  int located = 0;
  for (uint32_t i = 0; i < a.points.size(); ++i) {
    const MapPoint* point = scene_.map.FindPoint(a.points[i]);
    if (point == nullptr || !point->observations.contains(b.id())) continue;
    const auto position = LocatePoint(true_a, i, true_b, point->observations.at(b.id()));
    if (!position.has_value()) continue;
    const Eigen::Vector3d truth = scene_.true_position_in_map.at(point->id);
    EXPECT_LT((*position - truth).norm(), 0.05 * (true_a.camera_from_map * truth).norm());
    ++located;
  }
  EXPECT_GT(located, 50);
}

TEST_F(MappingTest, PixelsOfDifferentPointsMakeNone) {
  const Keyframe& a = *scene_.map.FindKeyframe({kOwn, 0});
  const Keyframe& b = *scene_.map.FindKeyframe({kOwn, 1});
  int located = 0;
  for (uint32_t i = 0; i < 40; ++i) located += LocatePoint(a, i, b, i + 17).has_value();
  EXPECT_LE(located, 2);
}

TEST_F(MappingTest, MapperBuildsTheSceneAndAdjustsItsPoses) {
  SampleLog local_ba_ms;
  Mapper mapper({}, {&map_, &queue_, &statistics_, nullptr, nullptr, nullptr, &local_ba_ms});
  for (uint32_t k = 0; k < 8; ++k) {
    Rigid3d pose = scene_.true_camera_from_map.at({kOwn, k});
    // The pose that tracking hands over is a little off.
    if (k > 0) pose.translation += Eigen::Vector3d(0.01, -0.01, 0.02);
    NewKeyframe keyframe = Handed(k, pose);
    SeeMapPoints(keyframe);
    ASSERT_TRUE(queue_.PushKeyframe(std::move(keyframe)));
    ASSERT_TRUE(mapper.Step());
  }
  EXPECT_FALSE(mapper.Step());
  EXPECT_FALSE(local_ba_ms.Copy().values().empty());
  map_.Read([&](const Map& map) {
    EXPECT_GE(map.keyframes().size(), 3u);
    for (const auto& [id, keyframe] : map.keyframes()) {
      const Eigen::Vector3d truth = CameraCentre(scene_.true_camera_from_map.at(id));
      EXPECT_LT((CameraCentre(keyframe.camera_from_map) - truth).norm(), 0.02);
    }
    int seen_often = 0;
    for (const auto& [id, point] : map.points()) seen_often += point.observations.size() >= 3;
    EXPECT_GT(seen_often, 50);
  });
}

TEST_F(MappingTest, LooksMoveKeypointsOnceTheirKeyframeIsSettled) {
  MeasurementBook measurements;
  MapperParts parts{&map_, &queue_, &statistics_, nullptr, nullptr};
  parts.measurements = &measurements;
  Mapper mapper({}, parts);
  for (uint32_t k = 0; k < 8; ++k) {
    KeypointMeasurement measurement;
    measurement.keyframe = {kOwn, k};
    measurement.shift_px = {1, 0};
    // The measurement is so sure that the keypoint goes all the way.
    measurement.variance_px2 = 1e-6;
    measurements.Add({measurement});
    NewKeyframe keyframe = Handed(k);
    SeeMapPoints(keyframe);
    ASSERT_TRUE(queue_.PushKeyframe(std::move(keyframe)));
    ASSERT_TRUE(mapper.Step());
    // Keyframes that hold loop edges are not culled.
    if (k > 0) map_.Write([&](Map& map) { map.AddLoopEdge({kOwn, k}, {kOwn, k - 1}); });
  }
  map_.Read([&](const Map& map) {
    const KeyframeId last_settled = NewestBut(map, kOwn, kProvisionalKeyframes);
    ASSERT_EQ(last_settled, (KeyframeId{kOwn, 1}));
    for (const auto& [id, keyframe] : map.keyframes()) {
      const bool is_settled = id <= last_settled;
      const float before_px = scene_.map.FindKeyframe(id)->keypoints()[0].x_px;
      EXPECT_NEAR(keyframe.keypoints()[0].x_px, before_px + (is_settled ? 1 : 0), 1e-3)
          << ToString(id);
    }
  });
}

TEST_F(MappingTest, KeyframesThatComeDuringAnAdjustmentAreInsertedAndMapped) {
  std::vector<uint32_t> mapped;
  uint32_t next = 0;
  const auto hand_next = [&] {
    NewKeyframe keyframe = Handed(next++);
    SeeMapPoints(keyframe);
    ASSERT_TRUE(queue_.PushKeyframe(std::move(keyframe)));
  };
  MapperOptions options;
  int during = 0;
  options.local_bundle.keep_going = [&](double) {
    if (next < 6 && queue_.keyframes() == 0) {
      hand_next();
      ++during;
    }
    return true;
  };
  Mapper mapper(options, {&map_, &queue_, &statistics_,
                          [&mapped](KeyframeId id) { mapped.push_back(id.index); }, nullptr});
  while (next < 3) {
    hand_next();
    ASSERT_TRUE(mapper.Step());
  }
  while (mapper.Step()) {
  }
  EXPECT_EQ(mapped, (std::vector<uint32_t>{0, 1, 2, 3, 4, 5}));
  EXPECT_GE(during, 3);
  EXPECT_TRUE(queue_.IsIdle());
}

// A store that shares a large map does this: each piece that is placed makes room for the next.
TEST_F(MappingTest, AKeyframeDoesNotWaitForAStreamOfJobs) {
  std::vector<uint32_t> mapped;
  Mapper mapper({}, {&map_, &queue_, &statistics_,
                     [&mapped](KeyframeId id) { mapped.push_back(id.index); }, nullptr});
  int jobs = 0;
  const std::function<void(GuardedMap&)> job = [&](GuardedMap&) {
    ++jobs;
    queue_.PostJob(job);
  };
  queue_.PostJob(job);
  ASSERT_TRUE(mapper.Step());
  for (uint32_t k = 0; k < 3; ++k) ASSERT_TRUE(queue_.PushKeyframe(Handed(k)));
  ASSERT_TRUE(mapper.Step());
  EXPECT_EQ(queue_.keyframes(), 0u);
  map_.Read([](const Map& map) { EXPECT_EQ(map.keyframes().size(), 3u); });
  for (int step = 0; step < 5; ++step) ASSERT_TRUE(mapper.Step());
  EXPECT_EQ(mapped, (std::vector<uint32_t>{0, 1, 2}));
  EXPECT_GE(jobs, 3);
}

TEST_F(MappingTest, AJobDoesNotWaitForAStreamOfKeyframes) {
  uint32_t next = 0;
  bool done = false;
  Mapper mapper({}, {&map_, &queue_, &statistics_,
                     [&](KeyframeId) { queue_.PushKeyframe(Handed(next++)); }, nullptr});
  ASSERT_TRUE(queue_.PushKeyframe(Handed(next++)));
  ASSERT_TRUE(mapper.Step());
  queue_.PostJob([&done](GuardedMap&) { done = true; });
  ASSERT_TRUE(mapper.Step());
  ASSERT_TRUE(mapper.Step());
  EXPECT_TRUE(done);
  EXPECT_FALSE(queue_.IsIdle());
}

TEST_F(MappingTest, RecentPointsAreCulledWhenTheyAreNotFound) {
  const auto made = InsertKeyframe(Handed(0), map_);
  RecentPoints recent(&statistics_);
  recent.Add(made, {kOwn, 0});
  const size_t before = CountPoints();
  for (int i = 0; i < 4; ++i) statistics_.Count({made[0]}, {});
  recent.Cull({kOwn, 1}, map_);
  EXPECT_EQ(CountPoints(), before - 1);
  map_.Read([&](const Map& map) { EXPECT_EQ(map.FindPoint(made[0]), nullptr); });
  // Two keyframes on, one observation is too few, whatever was found.
  recent.Cull({kOwn, 2}, map_);
  EXPECT_EQ(CountPoints(), 0u);
}

TEST_F(MappingTest, PointsOfKeyframesThatCameMeanwhileAreNotOld) {
  InsertKeyframe(Handed(0), map_);
  const auto made = InsertKeyframe(Handed(1), map_);
  RecentPoints recent(&statistics_);
  recent.Add(made, {kOwn, 1});
  const size_t before = CountPoints();
  recent.Cull({kOwn, 0}, map_);
  EXPECT_EQ(CountPoints(), before);
}

TEST_F(MappingTest, OfDuplicatesTheForeignPointSurvives) {
  InsertKeyframe(Handed(0), map_);
  map_.Write([&](Map& map) {
    const KeyframeId keyframe{kOwn, 0};
    const MapPointId own = map.points().begin()->first;
    const uint32_t keypoint = map.points().begin()->second.observations.at(keyframe);
    MapPoint foreign = map.points().begin()->second;
    foreign.id = {LocalMapId{99}, 5};
    map.AddPoint(foreign);
    ApplyFuseProposals(keyframe, {{foreign.id, keypoint, own}}, kOwn, map);
    EXPECT_EQ(map.FindPoint(own), nullptr);
    EXPECT_EQ(map.FindKeyframe(keyframe)->points[keypoint], foreign.id);
  });
}

class CrowdedMappingTest : public MappingTest {
 protected:
  static testing::SyntheticSceneOptions Crowded() {
    testing::SyntheticSceneOptions options;
    options.keyframes = 8;
    options.points = 400;
    options.step_m = 0.01;
    return options;
  }
  CrowdedMappingTest() : MappingTest(Crowded()) {}
};

TEST_F(CrowdedMappingTest, KeyframesThatSeeNothingNewAreRedundantButNotTheRoot) {
  const KeyframeId newest{kOwn, 7};
  const auto redundant = FindRedundantKeyframes(scene_.map, newest, kOwn);
  EXPECT_GE(redundant.size(), 3u);
  for (const KeyframeId id : redundant) {
    EXPECT_NE(id.index, 0u);
    EXPECT_NE(id, newest);
  }
  EXPECT_TRUE(FindRedundantKeyframes(scene_.map, newest, LocalMapId{5}).empty());
  Map map = scene_.map;
  map.AddLoopEdge(redundant[0], redundant[1]);
  const auto others = FindRedundantKeyframes(map, newest, kOwn);
  EXPECT_EQ(others.size(), redundant.size() - 2);
}

TEST_F(CrowdedMappingTest, OthersKeyframesMakeNoneRedundant) {
  const KeyframeId own{kOwn, 7};
  ASSERT_FALSE(FindRedundantKeyframes(scene_.map, own, kOwn).empty());
  // Five of the eight are another robot's.
  Map map = scene_.map;
  for (uint32_t k = 1; k < 6; ++k) {
    const Keyframe before = *map.FindKeyframe({kOwn, k});
    Keyframe others;
    others.payload = MakeKeyframePayload({LocalMapId{99}, k}, 0, 0, before.payload->camera,
                                         before.payload->features);
    others.camera_from_map = before.camera_from_map;
    map.RemoveKeyframe(before.id());
    map.AddKeyframe(others);
    for (uint32_t i = 0; i < before.points.size(); ++i) {
      map.AddObservation(before.points[i], others.id(), i);
    }
  }
  ASSERT_GT(map.FindKeyframe({kOwn, 6})->covisible.at({LocalMapId{99}, 5}), 100);
  EXPECT_TRUE(FindRedundantKeyframes(map, own, kOwn).empty());
}

TEST_F(CrowdedMappingTest, KeyframesThatWaitToBeMappedAreNotCulled) {
  std::vector<uint32_t> mapped;
  std::vector<uint32_t> removed;
  Mapper mapper(
      {}, {&map_, &queue_, &statistics_, [&mapped](KeyframeId id) { mapped.push_back(id.index); },
           [&](KeyframeId id) {
             EXPECT_THAT(mapped, ::testing::Contains(id.index)) << "removed before";
             removed.push_back(id.index);
           }});
  for (uint32_t k = 0; k < 8; ++k) {
    NewKeyframe keyframe = Handed(k);
    SeeMapPoints(keyframe);
    ASSERT_TRUE(queue_.PushKeyframe(std::move(keyframe)));
    // The last three wait together: two come into the map while the first of them is adjusted.
    if (k == 5 || k == 6) continue;
    while (mapper.Step()) {
    }
  }
  EXPECT_EQ(mapped, (std::vector<uint32_t>{0, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_FALSE(removed.empty());
}

TEST_F(CrowdedMappingTest, RemovedKeyframeTakesWeakPointsAlong) {
  Map map = scene_.map;
  RemoveKeyframeAndItsPoints({kOwn, 3}, map);
  EXPECT_EQ(map.FindKeyframe({kOwn, 3}), nullptr);
  for (const auto& [id, point] : map.points()) EXPECT_GT(CountObservations(map, point), 2);
}

}  // namespace
}  // namespace corbslam::client_agent
