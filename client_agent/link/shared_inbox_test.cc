#include "client_agent/link/shared_inbox.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "client_agent/link/testing/fake_map_jobs.h"
#include "client_agent/link/testing/fake_uplink.h"
#include "client_agent/link/testing/test_payload.h"

namespace corbslam::client_agent {
namespace {

constexpr LocalMapId kOwn{1};
constexpr LocalMapId kOther{2};

// Returns an update with the place of the first own keyframe and one foreign keyframe.
ArrivedUpdate Update(uint32_t index, size_t keypoints = 0) {
  ArrivedUpdate arrived;
  arrived.update.revision = index + 1;
  arrived.update.own_keyframes.push_back({{kOwn, 0}, {}, {}});
  SharedKeyframe keyframe;
  keyframe.payload = testing::MakeTestPayload({kOther, index}, keypoints);
  keyframe.points.resize(keypoints);
  arrived.update.keyframes.push_back(std::move(keyframe));
  arrived.words.push_back(std::make_shared<Words>());
  return arrived;
}

class SharedInboxTest : public ::testing::Test {
 protected:
  SharedInboxTest() {
    Keyframe first;
    first.payload = testing::MakeTestPayload({kOwn, 0}, 0);
    map_.Write([&](Map& map) { map.AddKeyframe(std::move(first)); });
  }
  std::shared_ptr<SharedInbox> MakeInbox(const InboxLimits& limits) {
    return std::make_shared<SharedInbox>(kOwn, jobs_, uplink_, limits);
  }

  FakeUplink uplink_;
  FakeMapJobs jobs_;
  GuardedMap map_{kOwn};
};

TEST_F(SharedInboxTest, OneJobPlacesAllThatArrived) {
  const auto inbox = MakeInbox({});
  for (uint32_t i = 0; i < 3; ++i) inbox->Add(Update(i));
  EXPECT_EQ(jobs_.size(), 1u);
  EXPECT_EQ(inbox->keyframes(), 0u);
  jobs_.Run(map_);
  EXPECT_EQ(inbox->keyframes(), 3u);
  EXPECT_EQ(jobs_.placed, 1);
  EXPECT_FALSE(uplink_.paused);
}

TEST_F(SharedInboxTest, TheSessionReadsNoMoreWhileTheInboxIsFull) {
  const auto inbox = MakeInbox({.max_updates = 3});
  for (uint32_t i = 0; i < 2; ++i) inbox->Add(Update(i));
  EXPECT_FALSE(uplink_.paused);
  inbox->Add(Update(2));
  EXPECT_TRUE(uplink_.paused);
  // The update that was being read when the pause came is not lost.
  inbox->Add(Update(3));
  jobs_.Run(map_);
  EXPECT_FALSE(uplink_.paused);
  EXPECT_EQ(inbox->keyframes(), 4u);
}

TEST_F(SharedInboxTest, BytesCountToo) {
  const size_t one = ApproximateBytes(Update(0, 1000).update);
  EXPECT_GT(one, 1000 * sizeof(Descriptor));
  const auto inbox = MakeInbox({.max_bytes = 2 * one});
  inbox->Add(Update(0, 1000));
  EXPECT_FALSE(uplink_.paused);
  inbox->Add(Update(1, 1000));
  EXPECT_TRUE(uplink_.paused);
  jobs_.Run(map_);
  EXPECT_FALSE(uplink_.paused);
  inbox->Add(Update(2, 1000));
  EXPECT_FALSE(uplink_.paused) << "what was taken does not count any more";
}

TEST_F(SharedInboxTest, AClosedOnePostsNothingAndLetsTheSessionRead) {
  const auto inbox = MakeInbox({.max_updates = 1});
  inbox->Add(Update(0));
  EXPECT_TRUE(uplink_.paused);
  inbox->Close();
  EXPECT_FALSE(uplink_.paused);
  jobs_.Run(map_);
  inbox->Add(Update(1));
  EXPECT_EQ(jobs_.size(), 0u);
  EXPECT_FALSE(uplink_.paused);
  EXPECT_EQ(inbox->keyframes(), 0u);
}

// A pose of before a correction and a place of after it would be off by twice what was corrected.
TEST_F(SharedInboxTest, APoseOfBeforeACorrectionIsPlacedAsBefore) {
  const auto inbox = MakeInbox({});
  inbox->Add(Update(0));
  jobs_.Run(map_);
  const Rigid3d moved = {Eigen::Quaterniond::Identity(), {1, 0, 0}};
  map_.Write([&](Map& map) {
    map.SetPose({kOwn, 0}, moved);
    map_.CountCorrection();
  });
  OwnCorrection correction;
  correction.motions[{kOwn, 0}] = {Rigid3d::Identity(), moved};
  inbox->Correct(correction, map_);
  ASSERT_EQ(map_.corrections(), 2u) << "the own map's, and what hangs on it";
  ASSERT_TRUE(inbox->GlobalFromLocal(0).has_value());
  EXPECT_EQ(inbox->GlobalFromLocal(0)->translation.x(), 0);
  EXPECT_EQ(inbox->GlobalFromLocal(1)->translation.x(), 1);
  EXPECT_EQ(inbox->GlobalFromLocal(2)->translation.x(), 1);
  EXPECT_EQ(inbox->GlobalFromLocal()->translation.x(), 1);
}

TEST_F(SharedInboxTest, WhatIsLeftOutGoesOnTheMappingThread) {
  const auto inbox = MakeInbox({});
  inbox->Add(Update(0));
  jobs_.Run(map_);
  ASSERT_EQ(inbox->keyframes(), 1u);
  inbox->LeaveOut(kOther);
  EXPECT_EQ(inbox->keyframes(), 1u);
  jobs_.Run(map_);
  EXPECT_EQ(inbox->keyframes(), 0u);
  inbox->Close();
  inbox->LeaveOut(kOther);
  EXPECT_EQ(jobs_.size(), 0u);
}

}  // namespace
}  // namespace corbslam::client_agent
