// Tests tracking and mapping together, on the features of a synthetic scene.
#include "client_agent/tracking/tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <thread>

#include "absl/time/clock.h"
#include "client_agent/mapping/mapper.h"
#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam::client_agent {
namespace {

KeyframePayload At(int64_t timestamp_ns, Features features) {
  return {.timestamp_ns = timestamp_ns, .features = std::move(features)};
}

testing::SyntheticSceneOptions SceneOptions() {
  testing::SyntheticSceneOptions options;
  options.keyframes = 40;
  options.points = 4000;
  options.step_m = 0.1;
  options.nearest_m = 2;
  options.farthest_m = 8;
  options.pixel_noise_px = 0.1;
  return options;
}

const testing::SyntheticScene& Scene() {
  static const auto* scene = new testing::SyntheticScene(MakeSyntheticScene(SceneOptions()));
  return *scene;
}

TrackerOptions Options() {
  TrackerOptions options;
  options.min_keyframes_to_wait = 2;
  return options;
}

class TrackerTest : public ::testing::Test {
 protected:
  TrackerTest()
      : map_(LocalMapId{42}),
        vocabulary_(*Vocabulary::Load(std::string(CORBSLAM_SOURCE_DIR) +
                                      "/slam/vocabulary/data/corbslam.voc")),
        find_places_([this](const Words&) { return places_; }),
        mapper_({}, {&map_, &queue_, &statistics_,
                     [this](KeyframeId id) { places_.insert(places_.begin(), id); }, nullptr}),
        tracker_(Options(), std::make_shared<const Camera>(Scene().camera),
                 {&map_, &queue_, &statistics_, vocabulary_.get(), &find_places_}) {}

  static const Keyframe& Seen(uint32_t index) {
    return *Scene().map.FindKeyframe({SceneOptions().local_map, index});
  }

  TrackingResult Track(uint32_t index) {
    return Finish(tracker_.Track(At(index * 100'000'000, Seen(index).payload->features)));
  }

  // A good picture of a place that nobody has seen.
  TrackingResult TrackElsewhere() {
    Features features = Seen(0).payload->features;
    for (Descriptor& descriptor : features.descriptors) {
      for (auto& word : descriptor.words) word = random_();
    }
    return Finish(tracker_.Track(At(1, features)));
  }

  TrackingResult TrackNothing() { return Finish(tracker_.Track(At(1, Features()))); }

  TrackingResult Finish(const TrackingResult& result) {
    while (mapper_.Step()) {
    }
    return result;
  }

  static Rigid3d TrueMotion(uint32_t from, uint32_t to) {
    const auto& truth = Scene().true_camera_from_map;
    return truth.at(Seen(to).id()) * truth.at(Seen(from).id()).Inverse();
  }

  // Has an IMU say how the camera moved, with a standard deviation of position.
  void ExpectMotion(uint32_t from, uint32_t to, double sigma_m = 0.02) {
    InertialMotion motion;
    motion.camera_from_previous = TrueMotion(from, to);
    motion.since_ns = (int64_t{to} - from) * 100'000'000;
    motion.covariance = Matrix6d::Identity() * (sigma_m * sigma_m);
    motion.covariance.bottomRightCorner<3, 3>() = Eigen::Matrix3d::Identity() * 1e-6;
    tracker_.Expect(motion);
  }

  TrackingResult TrackDark(uint32_t index) {
    return Finish(tracker_.Track(At(index * 100'000'000, Features())));
  }

  // What the frame shows looks as nothing does that was seen before, but alike from frame to frame.
  TrackingResult TrackUnknown(uint32_t index) {
    Features features = Seen(index).payload->features;
    for (Descriptor& descriptor : features.descriptors) {
      for (auto& word : descriptor.words) word ^= 0x5a5a5a5a5a5a5a5aull;
    }
    return Finish(tracker_.Track(At(index * 100'000'000, features)));
  }

  // Distance of the estimated camera from the truth, in the first camera's frame.
  static double Error(const TrackingResult& result, uint32_t index) {
    const auto& truth = Scene().true_camera_from_map;
    const Rigid3d expected = truth.at(Seen(index).id()) * truth.at(Seen(0).id()).Inverse();
    return (CameraCentre(result.camera_from_local) - CameraCentre(expected)).norm();
  }

  // Moves the map along x of the first camera, as a correction does.
  void MoveMap(double shift) {
    map_.Write([&](Map& map) {
      const Map before = map;
      for (const auto& [id, keyframe] : before.keyframes()) {
        Rigid3d pose = keyframe.camera_from_map;
        pose.translation -= pose.rotation * Eigen::Vector3d(shift, 0, 0);
        map.SetPose(id, pose);
      }
      for (const auto& [id, point] : before.points()) {
        map.SetPosition(id, point.position_in_map + Eigen::Vector3d(shift, 0, 0));
      }
      map_.CountCorrection();
    });
  }

  GuardedMap map_;
  MappingQueue queue_;
  PointStatistics statistics_;
  std::shared_ptr<const Vocabulary> vocabulary_;
  std::vector<KeyframeId> places_;
  PlaceFinder find_places_;
  Mapper mapper_;
  Tracker tracker_;
  std::mt19937_64 random_{11};
};

TEST_F(TrackerTest, FollowsTheWayAndMakesKeyframes) {
  int keyframes = 0;
  for (uint32_t i = 0; i < 40; ++i) {
    const TrackingResult result = Track(i);
    ASSERT_EQ(result.state, TrackingState::kTracking) << i;
    EXPECT_LT(Error(result, i), 0.02) << i;
    keyframes += result.made_keyframe;
  }
  EXPECT_GE(keyframes, 3);
  EXPECT_LE(keyframes, 38);
}

TEST_F(TrackerTest, PoseFollowsItsReference) {
  for (uint32_t i = 0; i < 5; ++i) {
    const TrackingResult result = Track(i);
    const auto reference = map_.ReadWithHistory([&](const Map& map, const MapHistory& history) {
      return history.CameraFromMap(map, result.reference);
    });
    ASSERT_TRUE(reference.has_value());
    const Rigid3d chained = result.reference_from_camera.Inverse() * *reference;
    EXPECT_LT((chained.translation - result.camera_from_local.translation).norm(), 0.02);
  }
}

TEST_F(TrackerTest, CorrectionsWhileAFrameIsTrackedDoNotTearItFromItsReference) {
  Track(0);
  std::mt19937 random(3);
  double shift = 0;
  for (uint32_t i = 1; i < 40; ++i) {
    std::jthread correction([this, pause = absl::Microseconds(random() % 20'000)] {
      absl::SleepFor(pause);
      MoveMap(1);
    });
    const TrackingResult tracked = tracker_.Track(At(i * 100'000'000, Seen(i).payload->features));
    correction.join();
    shift += 1;
    ASSERT_EQ(Finish(tracked).state, TrackingState::kTracking) << i;
    TrackingResult now = tracked;
    map_.ReadWithHistory([&](const Map& map, const MapHistory& history) {
      now.camera_from_local =
          now.reference_from_camera.Inverse() * *history.CameraFromMap(map, now.reference);
    });
    now.camera_from_local.translation +=
        now.camera_from_local.rotation * Eigen::Vector3d(shift, 0, 0);
    EXPECT_LT(Error(now, i), 0.05) << i;
  }
}

TEST_F(TrackerTest, BeginsOnlyWithEnoughKeypoints) {
  EXPECT_EQ(TrackNothing().state, TrackingState::kNotInitialised);
  Features few = Seen(0).payload->features;
  few.keypoints.resize(100);
  few.descriptors.resize(100);
  EXPECT_EQ(tracker_.Track(At(2, few)).state, TrackingState::kNotInitialised);
  EXPECT_EQ(tracker_.Track(At(2, few)).why_no_pose, WhyNoPose::kFewKeypoints);
  Features flat = Seen(0).payload->features;
  for (Keypoint& keypoint : flat.keypoints) keypoint.disparity_px = 0;
  EXPECT_EQ(tracker_.Track(At(2, flat)).why_no_pose, WhyNoPose::kFewDepths);
  EXPECT_FALSE(tracker_.IsLostForGood());
  EXPECT_EQ(Track(0).state, TrackingState::kTracking);
}

TEST_F(TrackerTest, FindsItsWayBackAfterBlackImages) {
  for (uint32_t i = 0; i < 40; ++i) Track(i);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(TrackNothing().state, TrackingState::kLost);
  EXPECT_FALSE(tracker_.IsLostForGood());
  // The camera is somewhere else than where it got lost.
  const TrackingResult result = Track(20);
  ASSERT_EQ(result.state, TrackingState::kTracking);
  EXPECT_LT(Error(result, 20), 0.02);
}

TEST_F(TrackerTest, ASuddenJumpIsNoFalsePose) {
  for (uint32_t i = 0; i < 20; ++i) Track(i);
  const TrackingResult result = Track(35);
  if (result.state == TrackingState::kTracking) {
    EXPECT_LT(Error(result, 35), 0.05);
  }
}

TEST_F(TrackerTest, AFreshMapIsGivenUpAtOnceALargeOneLater) {
  Track(0);
  EXPECT_EQ(TrackElsewhere().why_no_pose, WhyNoPose::kNotRecognised);
  EXPECT_TRUE(tracker_.IsLostForGood());
}

TEST_F(TrackerTest, WhatCoversTheCameraEndsNoMap) {
  for (uint32_t i = 0; i < 40; ++i) Track(i);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(TrackNothing().why_no_pose, WhyNoPose::kFewKeypoints);
    ASSERT_FALSE(tracker_.IsLostForGood());
  }
  const TrackingResult result = Track(20);
  ASSERT_EQ(result.state, TrackingState::kTracking);
  EXPECT_LT(Error(result, 20), 0.02);
}

TEST_F(TrackerTest, WhileMappingIsPausedTheMapStaysAsItIs) {
  for (uint32_t i = 0; i < 20; ++i) Track(i);
  const auto count = [this] {
    return map_.Read([](const Map& map) { return map.keyframes().size(); });
  };
  const size_t before = count();
  tracker_.PauseMapping(true);
  for (uint32_t i = 20; i < 26; ++i) EXPECT_FALSE(Track(i).made_keyframe) << i;
  for (int i = 0; i < 100; ++i) TrackElsewhere();
  EXPECT_FALSE(tracker_.IsLostForGood());
  EXPECT_EQ(Track(10).state, TrackingState::kTracking);
  EXPECT_EQ(count(), before);
  tracker_.PauseMapping(false);
  int keyframes = 0;
  for (uint32_t i = 20; i < 40; ++i) keyframes += Track(i).made_keyframe;
  EXPECT_GT(keyframes, 0);
}

TEST_F(TrackerTest, WhatAnImuExpectsIsFoundFurtherAwayThanMotionTakesIt) {
  for (uint32_t i = 0; i < 20; ++i) Track(i);
  ExpectMotion(19, 24);
  const TrackingResult result = Track(24);
  ASSERT_EQ(result.state, TrackingState::kTracking);
  EXPECT_LT(Error(result, 24), 0.02);
}

TEST_F(TrackerTest, DarkFramesAreWhereAnImuTakesThem) {
  for (uint32_t i = 0; i < 20; ++i) Track(i);
  for (uint32_t i = 20; i < 30; ++i) {
    ExpectMotion(19, i, 0.01 * (i - 19));
    TrackingResult result = TrackDark(i);
    ASSERT_EQ(result.state, TrackingState::kLost);
    ASSERT_TRUE(result.reckoned.has_value());
    result.camera_from_local = result.reckoned->camera_from_local;
    EXPECT_LT(Error(result, i), 0.03);
    const double sigma_m = std::sqrt(result.reckoned->covariance(0, 0));
    EXPECT_GE(sigma_m, 0.01 * (i - 19));
    EXPECT_LT(sigma_m, 0.02 + 0.01 * (i - 19));
  }
}

TEST_F(TrackerTest, NobodyKnowsWhereADarkFrameIsWithoutAnImu) {
  for (uint32_t i = 0; i < 20; ++i) Track(i);
  EXPECT_FALSE(TrackDark(20).reckoned.has_value());
  // What is expected from another frame on than the last one that had a pose is of no use.
  ExpectMotion(15, 21);
  EXPECT_FALSE(TrackDark(21).reckoned.has_value());
}

TEST_F(TrackerTest, ComesBackWhereAnImuTakesItWithoutAnyPlaceRecognised) {
  for (uint32_t i = 0; i < 30; ++i) Track(i);
  places_.clear();
  for (uint32_t i = 30; i < 33; ++i) {
    ExpectMotion(29, i);
    TrackDark(i);
  }
  ExpectMotion(29, 33, 0.05);
  const TrackingResult result = Track(33);
  ASSERT_EQ(result.state, TrackingState::kTracking);
  EXPECT_FALSE(result.was_bridged);
  EXPECT_LT(Error(result, 33), 0.02);
}

TEST_F(TrackerTest, GoesOnWithTheMapWhereAnImuTakesItWhenPicturesShowNothingKnown) {
  for (uint32_t i = 0; i < 20; ++i) Track(i);
  int bridges = 0;
  for (uint32_t i = 20; i < 40; ++i) {
    if (bridges == 0) ExpectMotion(19, i);
    const TrackingResult result = TrackUnknown(i);
    ASSERT_FALSE(tracker_.IsLostForGood());
    tracker_.Expect(std::nullopt);
    bridges += result.was_bridged ? 1 : 0;
    EXPECT_EQ(result.state, bridges == 0 ? TrackingState::kLost : TrackingState::kTracking) << i;
    if (bridges > 0) {
      EXPECT_LT(Error(result, i), 0.05) << i;
    }
  }
  EXPECT_EQ(bridges, 1);
  // All of it is one map, whose keyframes hang on each other.
  map_.Read([](const Map& map) {
    int roots = 0;
    for (const auto& [id, keyframe] : map.keyframes()) roots += keyframe.parent.IsValid() ? 0 : 1;
    EXPECT_EQ(roots, 1);
  });
}

class LittleSeenTest : public TrackerTest, public ::testing::WithParamInterface<bool> {};

TEST_P(LittleSeenTest, AnImuHelpsWhereThePictureBehindAGapShowsLittle) {
  const bool has_imu = GetParam();
  TrackingResult before;
  for (uint32_t i = 0; i < 30; ++i) before = Track(i);
  Features few = Seen(30).payload->features;
  std::normal_distribution<double> noise_px(0, 2);
  size_t kept = 0;
  for (size_t i = 0; i < few.keypoints.size(); i += 7) {
    few.keypoints[kept] = few.keypoints[i];
    few.keypoints[kept].x_px += static_cast<float>(noise_px(random_));
    few.keypoints[kept].y_px += static_cast<float>(noise_px(random_));
    few.descriptors[kept++] = few.descriptors[i];
  }
  few.keypoints.resize(kept);
  few.descriptors.resize(kept);
  Finish(tracker_.Track(At(2'950'000'000, Features())));
  InertialMotion motion;
  motion.camera_from_previous = TrueMotion(29, 30);
  motion.since_ns = 100'000'000;
  motion.covariance = Matrix6d::Identity() * 1e-5;
  if (has_imu) tracker_.Expect(motion);
  const TrackingResult result = Finish(tracker_.Track(At(3'000'000'000, few)));
  ASSERT_EQ(result.state, TrackingState::kTracking);
  const Rigid3d moved = result.camera_from_local * before.camera_from_local.Inverse();
  const double off_m = (moved.translation - TrueMotion(29, 30).translation).norm();
  if (has_imu) {
    EXPECT_LT(off_m, 0.006);
  } else {
    EXPECT_GT(off_m, 0.006);
  }
}

INSTANTIATE_TEST_SUITE_P(Imu, LittleSeenTest, ::testing::Bool());

TEST_F(TrackerTest, AMapDoesNotGoOnWhereTheImuHardlyKnows) {
  for (uint32_t i = 0; i < 20; ++i) Track(i);
  for (uint32_t i = 20; i < 40; ++i) {
    ExpectMotion(19, i, 0.5);
    EXPECT_EQ(TrackUnknown(i).state, TrackingState::kLost) << i;
  }
}

TEST_F(TrackerTest, WhileMappingIsPausedNothingIsBridged) {
  for (uint32_t i = 0; i < 20; ++i) Track(i);
  tracker_.PauseMapping(true);
  for (uint32_t i = 20; i < 40; ++i) {
    ExpectMotion(19, i);
    EXPECT_EQ(TrackUnknown(i).state, TrackingState::kLost) << i;
  }
}

TEST_F(TrackerTest, APlaceThatTheImuCannotHaveReachedIsNotBelieved) {
  for (uint32_t i = 0; i < 40; ++i) Track(i);
  Finish(tracker_.Track(At(4'000'000'000, Features())));
  InertialMotion stands;
  stands.since_ns = 4'200'000'000 - 3'900'000'000;
  stands.covariance = Matrix6d::Identity() * 1e-4;
  tracker_.Expect(stands);
  // The picture shows what was seen 3 m away.
  EXPECT_EQ(Finish(tracker_.Track(At(4'200'000'000, Seen(8).payload->features))).state,
            TrackingState::kLost);
  tracker_.Expect(std::nullopt);
  EXPECT_EQ(Finish(tracker_.Track(At(4'300'000'000, Seen(8).payload->features))).state,
            TrackingState::kTracking);
}

TEST_F(TrackerTest, APausedRobotBeginsNoMap) {
  tracker_.PauseMapping(true);
  EXPECT_EQ(Track(0).why_no_pose, WhyNoPose::kMappingPaused);
  tracker_.PauseMapping(false);
  EXPECT_EQ(Track(0).state, TrackingState::kTracking);
}

TEST_F(TrackerTest, SaysHowItMovedAndHowSurelyItKnows) {
  for (uint32_t i = 0; i < 10; ++i) Track(i);
  MoveMap(5);
  const TrackingResult result = Track(10);
  ASSERT_TRUE(result.motion.has_value());
  EXPECT_EQ(result.motion->since_ns, 100'000'000);
  const auto& truth = Scene().true_camera_from_map;
  const Rigid3d moved = truth.at(Seen(10).id()) * truth.at(Seen(9).id()).Inverse();
  EXPECT_LT((result.motion->camera_from_previous.translation - moved.translation).norm(), 0.02)
      << "whatever the map did";
  EXPECT_GT(result.corrections, 0u);
  EXPECT_GE(result.points_in_view, result.points_matched);
  ASSERT_TRUE(result.covariance.has_value());
  const double spread_m = std::sqrt(result.covariance->diagonal().head<3>().sum());
  EXPECT_GT(spread_m, 1e-5);
  EXPECT_LT(spread_m, 0.02);
}

// The map that the tracker goes on in, with what works on it.
struct NextMap {
  NextMap(const Vocabulary* vocabulary)
      : tracker(Options(), std::make_shared<const Camera>(Scene().camera),
                {&map, &queue, &statistics, vocabulary}) {}

  GuardedMap map{LocalMapId{43}};
  MappingQueue queue;
  PointStatistics statistics;
  Mapper mapper{{}, {&map, &queue, &statistics, nullptr, nullptr}};
  Tracker tracker;
};

TEST_F(TrackerTest, GoesOnInAnotherMapFromTheFrameThatBothSee) {
  TrackingResult before;
  for (uint32_t i = 0; i < 20; ++i) before = Track(i);
  const std::optional<HandedFrame> handed = tracker_.HandOver();
  ASSERT_TRUE(handed.has_value());
  NextMap next(vocabulary_.get());
  ASSERT_TRUE(next.tracker.TakeOver(*handed));
  for (uint32_t i = 20; i < 40; ++i) {
    const TrackingResult result =
        next.tracker.Track(At(i * 100'000'000, Seen(i).payload->features));
    while (next.mapper.Step()) {
    }
    ASSERT_EQ(result.state, TrackingState::kTracking) << i;
    EXPECT_EQ(result.local_map, LocalMapId{43});
    EXPECT_LT(Error(result, i), 0.03) << "in the frame of the map before, " << i;
    ASSERT_TRUE(result.motion.has_value()) << i;
    EXPECT_EQ(result.motion->since_ns, 100'000'000);
  }
  const Rigid3d first =
      next.map.Read([](const Map& map) { return map.keyframes().begin()->second.camera_from_map; });
  EXPECT_LT((CameraCentre(first) - CameraCentre(before.camera_from_local)).norm(), 1e-9);
}

TEST_F(TrackerTest, HandsOverOnlyWhatAMapCanBeginWith) {
  EXPECT_FALSE(tracker_.HandOver().has_value()) << "nothing was tracked yet";
  for (uint32_t i = 0; i < 10; ++i) Track(i);
  tracker_.PauseMapping(true);
  EXPECT_FALSE(tracker_.HandOver().has_value()) << "mapping is paused";
  tracker_.PauseMapping(false);
  Features flat = Seen(10).payload->features;
  for (size_t i = 0; i < flat.keypoints.size(); ++i) {
    if (i >= 50) flat.keypoints[i].disparity_px = 0;
  }
  ASSERT_EQ(Finish(tracker_.Track(At(1'000'000'000, flat))).state, TrackingState::kTracking);
  EXPECT_FALSE(tracker_.HandOver().has_value()) << "too few depths";
  Track(11);
  EXPECT_TRUE(tracker_.HandOver().has_value());
  TrackElsewhere();
  EXPECT_FALSE(tracker_.HandOver().has_value()) << "it is lost";
}

TEST_F(TrackerTest, ALargeMapIsGivenUpAfterManyLostFrames) {
  for (uint32_t i = 0; i < 40; ++i) Track(i);
  int frames = 0;
  while (!tracker_.IsLostForGood()) {
    TrackElsewhere();
    ASSERT_LT(++frames, 100);
  }
  EXPECT_GT(frames, 10);
}

TEST_F(TrackerTest, PointsOfOthersAreUsedAndCounted) {
  for (uint32_t i = 0; i < 10; ++i) Track(i);
  // All points become another local map's.
  map_.Write([](Map& map) {
    const Map copy = map;
    for (const auto& [id, point] : copy.points()) {
      MapPoint foreign = point;
      foreign.id.local_map = LocalMapId{77};
      map.AddPoint(foreign);
      map.ReplacePoint(id, foreign.id);
    }
  });
  const TrackingResult result = Track(10);
  ASSERT_EQ(result.state, TrackingState::kTracking);
  EXPECT_GT(result.foreign_points_matched, result.points_matched / 2);
  EXPECT_LT(Error(result, 10), 0.02);
}

// Where the camera was, in the frame of the first camera.
Rigid3d TruePose(uint32_t index) {
  const auto& truth = Scene().true_camera_from_map;
  const LocalMapId scene = SceneOptions().local_map;
  return truth.at({scene, index}) * truth.at({scene, 0}).Inverse();
}

Rigid3d Shifted(Rigid3d camera_from_map, double shift_m) {
  camera_from_map.translation += Eigen::Vector3d(shift_m, 0, 0);
  return camera_from_map;
}

TEST_F(TrackerTest, GoesOnWhereSomebodySaysThatALostFrameWas) {
  for (uint32_t i = 0; i < 20; ++i) Track(i);
  EXPECT_FALSE(tracker_.ResumeAt(tracker_.last_payload(), TruePose(19))) << "it is not lost";
  TrackElsewhere();
  places_.clear();
  ASSERT_EQ(Track(8).state, TrackingState::kLost) << "nothing finds it by its looks";
  const auto lost = tracker_.last_payload();
  EXPECT_FALSE(tracker_.ResumeAt(lost, Shifted(TruePose(8), 15))) << "the map shows nothing there";
  EXPECT_EQ(Track(8).state, TrackingState::kLost);
  ASSERT_TRUE(tracker_.ResumeAt(lost, Shifted(TruePose(8), 0.05)));
  for (uint32_t i = 9; i < 15; ++i) {
    const TrackingResult result = Track(i);
    ASSERT_EQ(result.state, TrackingState::kTracking) << i;
    EXPECT_LT(Error(result, i), 0.03) << i;
  }
}

TEST_F(TrackerTest, LocalisesInOthersMapAndLeavesItAsItIs) {
  for (uint32_t i = 0; i < 30; ++i) Track(i);
  GuardedMap others(LocalMapId{99});
  map_.Read([&](const Map& map) { others.Write([&](Map& copy) { copy = map; }); });
  const size_t keyframes = others.Read([](const Map& map) { return map.keyframes().size(); });
  TrackerOptions options = Options();
  options.localise_only = true;
  MappingQueue queue;
  PointStatistics statistics;
  std::vector<KeyframeId> places;
  const PlaceFinder find_places = [&](const Words&) { return places; };
  Tracker tracker(options, std::make_shared<const Camera>(Scene().camera),
                  {&others, &queue, &statistics, vocabulary_.get(), &find_places});
  const auto track = [&](uint32_t i) {
    return tracker.Track(At(i * 100'000'000, Seen(i).payload->features));
  };
  for (int i = 0; i < 60; ++i) {
    const TrackingResult lost = track(5);
    ASSERT_EQ(lost.state, TrackingState::kLost) << "where it is nobody has said";
    EXPECT_EQ(lost.why_no_pose, WhyNoPose::kNotRecognised);
  }
  EXPECT_FALSE(tracker.IsLostForGood()) << "there is no other map to begin";
  places = places_;
  for (uint32_t i = 5; i < 25; ++i) {
    const TrackingResult result = track(i);
    ASSERT_EQ(result.state, TrackingState::kTracking) << i;
    EXPECT_LT(Error(result, i), 0.03) << i;
    EXPECT_EQ(result.foreign_points_matched, result.points_matched) << i;
    EXPECT_TRUE(result.reference.IsValid()) << i;
    EXPECT_FALSE(result.made_keyframe) << i;
  }
  EXPECT_TRUE(queue.IsIdle());
  EXPECT_EQ(others.Read([](const Map& map) { return map.keyframes().size(); }), keyframes);
}

// With a rig of another camera a robot is lost, or its poses are no more wrong than they say.
TEST_F(TrackerTest, LocalisesNowhereWronglyWithAnotherCamera) {
  for (uint32_t i = 0; i < 30; ++i) Track(i);
  GuardedMap others(LocalMapId{99});
  map_.Read([&](const Map& map) { others.Write([&](Map& copy) { copy = map; }); });
  TrackerOptions options = Options();
  options.localise_only = true;
  MappingQueue queue;
  PointStatistics statistics;
  const PlaceFinder find_places = [&](const Words&) { return places_; };
  for (const double share : {0.4, 0.8, 1.15, 1.3, 2.2}) {
    Camera said = Scene().camera;
    said.fx_px *= share;
    said.fy_px *= share;
    Tracker tracker(options, std::make_shared<const Camera>(said),
                    {&others, &queue, &statistics, vocabulary_.get(), &find_places});
    for (uint32_t i = 5; i < 12; ++i) {
      Features features = Seen(i).payload->features;
      const TrackingResult result = tracker.Track(At(i * 100'000'000, features));
      if (result.state == TrackingState::kLost) continue;
      ASSERT_TRUE(result.covariance.has_value());
      const double sigma = std::sqrt(result.covariance->topLeftCorner<3, 3>().trace());
      EXPECT_LT(Error(result, i), 5 * sigma)
          << share << ", frame " << i << ", " << result.points_matched << " points";
      EXPECT_GT(share, 2) << "lost, unless what is in view is no more than the middle: sigma "
                          << sigma << " m, " << Error(result, i) << " m off";
    }
  }
}

}  // namespace
}  // namespace corbslam::client_agent
