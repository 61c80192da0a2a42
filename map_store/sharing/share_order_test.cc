// Tests which of the keyframes that an agent lacks come first.
#include "map_store/sharing/share_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <vector>

namespace corbslam::map_store {
namespace {

using ::testing::ElementsAre;

constexpr LocalMapId kOwn = {0xa};
constexpr LocalMapId kOthers = {0xb};

// The robot has driven along x, from 0 to where its newest keyframe is.
class ShareOrderTest : public ::testing::Test {
 protected:
  ShareOrderTest() {
    AddLocalMap(state_, kOwn, "a");
    AddLocalMap(state_, kOthers, "b");
    share_.local_map = kOwn;
  }

  void Add(KeyframeId id, double x, double y) {
    Keyframe keyframe;
    keyframe.payload = MakeKeyframePayload(id, id.index, 0, camera_, {});
    keyframe.camera_from_map = {Eigen::Quaterniond::Identity(), {-x, -y, 0}};
    state_.FindLocalMap(id.local_map)->map.AddKeyframe(std::move(keyframe));
  }
  // Adds another's keyframe, which waits.
  void AddWaiting(uint32_t index, double x, double y) {
    Add({kOthers, index}, x, y);
    waiting_.insert({kOthers, index});
  }
  // Adds keyframes that are far away, so that many wait.
  void AddMany() {
    for (uint32_t i = 0; i < 20; ++i) AddWaiting(1000 + i, 0, 500.0 + i);
  }
  // Returns the first of the others' keyframes, by index.
  std::vector<uint32_t> First(size_t count) {
    const Unplaced none;
    PoseCache poses(state_, none);
    std::vector<uint32_t> first;
    for (const KeyframeId& id : OrderNewKeyframes(state_, waiting_, poses, share_)) {
      if (first.size() < count) first.push_back(id.index);
    }
    return first;
  }

  const std::shared_ptr<const Camera> camera_ =
      std::make_shared<Camera>(Camera{500, 500, 320, 240, 640, 480, 0.1, 4});
  MissionState state_;
  ShareState share_;
  std::set<KeyframeId> waiting_;
};

TEST_F(ShareOrderTest, OfManyThoseAheadComeBeforeThoseBehind) {
  Add({kOwn, 0}, 0, 0);
  Add({kOwn, 1}, 1, 0);
  AddWaiting(1, -10, 0);  // Nearer than those ahead.
  AddWaiting(2, 12, 0);
  AddWaiting(3, 15, 0);
  AddWaiting(4, 1, 12);  // Beside the robot.
  AddMany();
  EXPECT_THAT(First(4), ElementsAre(2, 3, 4, 1));
}

TEST_F(ShareOrderTest, WhatIsMuchNearerComesFirstAlthoughItIsBehind) {
  Add({kOwn, 0}, 0, 0);
  Add({kOwn, 1}, 1, 0);
  AddWaiting(1, 8, 0);   // 7 m ahead.
  AddWaiting(2, -3, 0);  // 3 m behind, which counts as 6.
  AddMany();
  EXPECT_THAT(First(2), ElementsAre(2, 1));
}

TEST_F(ShareOrderTest, TheDirectionIsThatOfTheLastTwoKeyframes) {
  Add({kOwn, 0}, 0, 0);
  Add({kOwn, 1}, 1, 0);
  Add({kOwn, 2}, 0.5, 0);  // It turned back.
  AddWaiting(1, -10, 0);
  AddWaiting(2, 11, 0);
  AddMany();
  EXPECT_THAT(First(2), ElementsAre(1, 2));
}

TEST_F(ShareOrderTest, ARobotThatStandsOrHasJustBegunHasNoDirection) {
  Add({kOwn, 0}, 0, 0);
  AddWaiting(1, -10, 0);
  AddWaiting(2, 10.5, 0);
  AddMany();
  EXPECT_THAT(First(2), ElementsAre(1, 2));
  Add({kOwn, 1}, 0, 0);
  EXPECT_THAT(First(2), ElementsAre(1, 2));
}

TEST_F(ShareOrderTest, OfFewTheNearestComesFirst) {
  Add({kOwn, 0}, 0, 0);
  Add({kOwn, 1}, 1, 0);
  AddWaiting(1, -10, 0);
  AddWaiting(2, 12, 0);
  EXPECT_THAT(First(2), ElementsAre(1, 2));
}

TEST_F(ShareOrderTest, OwnLandmarksCountForMoreThanTheDirection) {
  Add({kOwn, 0}, 0, 0);
  Add({kOwn, 1}, 1, 0);
  AddWaiting(1, -10, 0);
  AddWaiting(2, 12, 0);
  AddMany();
  share_.news.own_landmarks[{kOthers, 1}] = 5;
  EXPECT_THAT(First(2), ElementsAre(1, 2));
}

}  // namespace
}  // namespace corbslam::map_store
