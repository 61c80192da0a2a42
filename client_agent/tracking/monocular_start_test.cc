#include "client_agent/tracking/monocular_start.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "client_agent/mapping/mapper.h"
#include "client_agent/tracking/tracker.h"
#include "slam/optimisation/testing/synthetic_scene.h"
#include "slam/util/median.h"

namespace corbslam::client_agent {
namespace {

testing::SyntheticSceneOptions DriveOptions() {
  testing::SyntheticSceneOptions options;
  options.keyframes = 40;
  options.points = 6000;
  options.step_m = 0.1;
  options.nearest_m = 3;
  options.farthest_m = 8;
  options.share_with_depth = 0;
  options.pixel_noise_px = 0.3;
  return options;
}

const testing::SyntheticScene& Drive() {
  static const auto* scene = new testing::SyntheticScene(MakeSyntheticScene(DriveOptions()));
  return *scene;
}

std::shared_ptr<const Camera> OneCamera() {
  static const auto camera = [] {
    Camera one = Drive().camera;
    one.baseline_m = 0;
    one.close_depth_m = 0;
    return std::make_shared<const Camera>(one);
  }();
  return camera;
}

KeyframePayload Picture(uint32_t index, int64_t timestamp_ns) {
  KeyframePayload picture;
  picture.timestamp_ns = timestamp_ns;
  picture.camera = OneCamera();
  picture.features = Drive().map.FindKeyframe({DriveOptions().local_map, index})->payload->features;
  return picture;
}

Frame FrameOf(uint32_t index) { return MakeFrame(Picture(index, index * 100'000'000)); }

Rigid3d TrueMotion(uint32_t from, uint32_t to) {
  const auto& truth = Drive().true_camera_from_map;
  return truth.at({DriveOptions().local_map, to}) *
         truth.at({DriveOptions().local_map, from}).Inverse();
}

TEST(MonocularStartTest, BeginsOnceTheCameraHasMovedAside) {
  MonocularStart start(1);
  std::optional<MonocularBeginning> beginning;
  uint32_t second = 0;
  for (uint32_t i = 0; i < 20 && !beginning.has_value(); ++i) {
    beginning = start.Add(FrameOf(i));
    second = i;
  }
  ASSERT_TRUE(beginning.has_value());
  EXPECT_GE(second, 1U);
  EXPECT_LE(second, 10U);
  const Rigid3d truth = TrueMotion(0, second);
  const Rigid3d& found = beginning->second.camera_from_map;
  EXPECT_LT(RotationAngle(found.rotation.conjugate() * truth.rotation), 0.01);
  EXPECT_GT(found.translation.normalized().dot(truth.translation.normalized()), 0.995);
  ASSERT_GE(beginning->points.size(), 50U);
  EXPECT_EQ(beginning->second.found_depths.size(), beginning->points.size());
  std::vector<double> depths;
  for (const FoundPoint& point : beginning->points) depths.push_back(point.position_in_map.z());
  EXPECT_NEAR(Median(std::move(depths)), 1, 0.05);
}

TEST(MonocularStartTest, WaitsWhileTheCameraStands) {
  MonocularStart start(1);
  for (int i = 0; i < 10; ++i) {
    EXPECT_FALSE(start.Add(FrameOf(3)).has_value());
    const TwoViewVerdict expected =
        i == 0 ? TwoViewVerdict::kFewMatches : TwoViewVerdict::kLittleParallax;
    EXPECT_EQ(start.verdict(), expected);
  }
}

TEST(MonocularStartTest, BeginsAnewWhereNothingIsFoundAgain) {
  MonocularStart start(1);
  start.Add(FrameOf(0));
  Frame other = FrameOf(1);
  KeyframePayload strange = *other.payload;
  for (Descriptor& descriptor : strange.features.descriptors) {
    for (auto& word : descriptor.words) word = ~word * 0x9e3779b97f4a7c15ull;
  }
  EXPECT_FALSE(start.Add(MakeFrame(strange)).has_value());
  EXPECT_EQ(start.verdict(), TwoViewVerdict::kFewMatches);
  std::optional<MonocularBeginning> beginning;
  for (uint32_t i = 10; i < 25 && !beginning.has_value(); ++i) beginning = start.Add(FrameOf(i));
  ASSERT_TRUE(beginning.has_value());
  EXPECT_GE(beginning->first.payload->timestamp_ns, 1'000'000'000);
}

// Tracking and mapping of one camera together.
class MonocularTrackingTest : public ::testing::Test {
 protected:
  MonocularTrackingTest()
      : map_(LocalMapId{42}),
        vocabulary_(*Vocabulary::Load(std::string(CORBSLAM_SOURCE_DIR) +
                                      "/slam/vocabulary/data/corbslam.voc")),
        find_places_([this](const Words&) { return places_; }),
        mapper_({}, {&map_, &queue_, &statistics_,
                     [this](KeyframeId id) { places_.insert(places_.begin(), id); }, nullptr}),
        tracker_(TrackerOptions(), OneCamera(),
                 {&map_, &queue_, &statistics_, vocabulary_.get(), &find_places_}) {}

  TrackingResult Track(uint32_t index, bool maps = true) {
    const TrackingResult result = tracker_.Track(Picture(index, index * 100'000'000));
    while (maps && mapper_.Step()) {
    }
    return result;
  }

  GuardedMap map_;
  MappingQueue queue_;
  PointStatistics statistics_;
  std::shared_ptr<const Vocabulary> vocabulary_;
  std::vector<KeyframeId> places_;
  PlaceFinder find_places_;
  Mapper mapper_;
  Tracker tracker_;
};

TEST_F(MonocularTrackingTest, FollowsTheCameraUpToOneScale) {
  std::optional<uint32_t> first;
  std::vector<double> scales;
  for (uint32_t i = 0; i < 40; ++i) {
    const TrackingResult result = Track(i);
    if (result.state != TrackingState::kTracking) {
      EXPECT_FALSE(first.has_value()) << "lost at " << i;
      EXPECT_EQ(result.why_no_pose, WhyNoPose::kLittleParallax);
      continue;
    }
    if (!first.has_value()) first = i;
    const Eigen::Vector3d centre = CameraCentre(result.camera_from_local);
    const Eigen::Vector3d truth = CameraCentre(TrueMotion(0, i));
    scales.push_back(centre.norm() / truth.norm());
    EXPECT_GT(centre.normalized().dot(truth.normalized()), 0.995) << i;
  }
  ASSERT_TRUE(first.has_value());
  EXPECT_LE(*first, 10U);
  const auto [least, most] = std::minmax_element(scales.begin(), scales.end());
  EXPECT_LT(*most / *least, 1.1);
  map_.Read([&](const Map& map) {
    EXPECT_GT(map.keyframes().size(), 3U);
    EXPECT_GT(map.points().size(), 500U);
    // Its first keyframe is the root, at the origin.
    EXPECT_FALSE(map.keyframes().begin()->second.parent.IsValid());
    EXPECT_TRUE(map.keyframes().begin()->second.camera_from_map.translation.isZero(0));
  });
}

TEST_F(MonocularTrackingTest, GoesOnBeforeMappingHasTakenTheBeginning) {
  std::optional<uint32_t> first;
  for (uint32_t i = 0; i < 30; ++i) {
    const bool has_begun = first.has_value();
    const TrackingResult result = Track(i, /*maps=*/!has_begun || i > *first + 3);
    if (result.state == TrackingState::kTracking && !first.has_value()) first = i;
    EXPECT_TRUE(!has_begun || result.state == TrackingState::kTracking) << i;
  }
  ASSERT_TRUE(first.has_value());
}

TEST_F(MonocularTrackingTest, HandsNothingOver) {
  for (uint32_t i = 0; i < 20; ++i) Track(i);
  EXPECT_FALSE(tracker_.HandOver().has_value());
}

TEST_F(MonocularTrackingTest, APausedRobotBeginsNothing) {
  tracker_.PauseMapping(true);
  for (uint32_t i = 0; i < 15; ++i) {
    EXPECT_EQ(Track(i).why_no_pose, WhyNoPose::kMappingPaused);
  }
  EXPECT_TRUE(map_.Read([](const Map& map) { return map.keyframes().empty(); }));
}

}  // namespace
}  // namespace corbslam::client_agent
