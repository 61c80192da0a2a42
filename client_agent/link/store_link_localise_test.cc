// Tests the link of a robot that only localises.
#include <gmock/gmock.h>

#include <memory>
#include <vector>

#include "client_agent/link/store_link.h"
#include "client_agent/link/testing/fake_map_jobs.h"
#include "client_agent/link/testing/fake_uplink.h"
#include "client_agent/link/testing/test_payload.h"
#include "gtest/gtest.h"

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

constexpr LocalMapId kGuestsMap{1};

// A map store that takes the frames of such robots.
class LocalisingUplink : public FakeUplink {
 public:
  bool SendLocalised(const std::vector<LocalisedFrame>& frames) override {
    if (!open || !takes) return false;
    localised.insert(localised.end(), frames.begin(), frames.end());
    ++messages;
    return true;
  }
  bool takes = true;
  int messages = 0;
  std::vector<LocalisedFrame> localised;
};

class StoreLinkLocaliseTest : public ::testing::Test {
 protected:
  StoreLinkLocaliseTest() { uplink_.capabilities.localise_only = true; }

  std::unique_ptr<StoreLink> MakeLink() {
    StoreLinkOptions options;
    options.mission = "m";
    options.agent = "guest";
    options.localise_only = true;
    options.flush_interval = absl::Seconds(1);
    options.min_backoff = options.max_backoff = absl::ZeroDuration();
    options.clock = [this] { return now_; };
    auto link = std::make_unique<StoreLink>(options, &uplink_,
                                            [](const auto&) { return std::make_shared<Words>(); });
    link->BeginLocalMap(map_, jobs_);
    return link;
  }

  LocalisingUplink uplink_;
  FakeMapJobs jobs_;
  GuardedMap map_{kGuestsMap};
  absl::Time now_ = absl::UnixEpoch() + absl::Hours(1);
};

TEST_F(StoreLinkLocaliseTest, FramesGoUpAndNoBatchDoes) {
  const auto link = MakeLink();
  link->Step();
  ASSERT_EQ(uplink_.requests.size(), 1u);
  EXPECT_TRUE(uplink_.requests[0].localise_only);
  EXPECT_TRUE(uplink_.requests[0].local_maps.empty());
  link->AddLocalised({1, Rigid3d::Identity()});
  link->AddLocalised({2, std::nullopt});
  link->AddTrackedFrame({1, {{2}, 0}, Rigid3d::Identity()});
  link->AddLostFrame(2);
  link->Step();
  ASSERT_EQ(uplink_.localised.size(), 2u);
  EXPECT_TRUE(uplink_.localised[0].camera_from_global.has_value());
  EXPECT_FALSE(uplink_.localised[1].camera_from_global.has_value());
  // Within a second they wait for each other; what is left goes at the end.
  link->AddLocalised({3, Rigid3d::Identity()});
  link->AddLocalised({4, Rigid3d::Identity()});
  link->Step();
  EXPECT_EQ(uplink_.messages, 1);
  now_ += absl::Seconds(2);
  link->Step();
  EXPECT_EQ(uplink_.messages, 2);
  link->AddLocalised({5, Rigid3d::Identity()});
  EXPECT_TRUE(link->Finish(absl::Seconds(1)).ok());
  EXPECT_EQ(uplink_.localised.size(), 5u);
  EXPECT_TRUE(uplink_.stored.empty());
}

TEST_F(StoreLinkLocaliseTest, FramesWaitForTheLinkTheNewestOfThem) {
  uplink_.reachable = false;
  const auto link = MakeLink();
  link->Step();
  const int64_t frames = LocalisedOutbox::kMaxFrames + 10;
  for (int64_t i = 0; i < frames; ++i) link->AddLocalised({i, Rigid3d::Identity()});
  uplink_.reachable = true;
  uplink_.takes = false;
  link->Step();
  EXPECT_TRUE(uplink_.localised.empty());
  uplink_.takes = true;
  link->Step();
  ASSERT_EQ(uplink_.localised.size(), LocalisedOutbox::kMaxFrames);
  EXPECT_EQ(uplink_.localised.back().timestamp_ns, frames - 1);
}

TEST_F(StoreLinkLocaliseTest, AnOlderStoreIsRefusedWithWhatToDo) {
  uplink_.capabilities.localise_only = false;
  const auto link = MakeLink();
  link->Step();
  link->AddLocalised({1, Rigid3d::Identity()});
  link->Step();
  EXPECT_TRUE(uplink_.localised.empty());
  const absl::Status finished = link->Finish(absl::Seconds(1));
  EXPECT_TRUE(absl::IsFailedPrecondition(finished)) << finished;
  EXPECT_THAT(std::string(finished.message()), HasSubstr("without --localise-only"));
}

TEST_F(StoreLinkLocaliseTest, OthersKeyframesArePlacedWhereTheStoreSaysThatTheFrameLies) {
  const auto link = MakeLink();
  link->Step();
  SharedUpdate update;
  update.revision = 1;
  update.global_from_local = Similarity3d::Identity();
  uplink_.Share(update);
  jobs_.Run(map_);
  ASSERT_TRUE(link->GlobalFromLocal().has_value());
  EXPECT_TRUE(link->GlobalFromLocal()->ToRigid().translation.isZero(0));
  EXPECT_FALSE(link->NeedsNewLocalMap());
}

// What others made within some place of the global frame, which is the robot's own.
SharedUpdate Others(uint32_t first, uint32_t count) {
  SharedUpdate update;
  update.revision = first + 1;
  update.global_from_local = Similarity3d::Identity();
  for (uint32_t i = first; i < first + count; ++i) {
    SharedKeyframe keyframe;
    keyframe.payload = testing::MakeTestPayload({{9}, i}, 0);
    update.keyframes.push_back(std::move(keyframe));
  }
  return update;
}

TEST_F(StoreLinkLocaliseTest, WhatIsFarGoesWhenEnoughOfWhatIsNearIsHere) {
  const auto link = MakeLink();
  const auto held = [&] {
    jobs_.Run(map_);
    return map_.Read([](const Map& map) { return map.keyframes().size(); });
  };
  link->Step();
  uplink_.Share(Others(0, 100));
  EXPECT_EQ(held(), 100u);
  link->AskAnew(20);
  link->Step();
  ASSERT_EQ(uplink_.requests.size(), 2u);
  EXPECT_EQ(uplink_.requests[1].last_revision, 0u) << "the store is to tell all again";
  EXPECT_EQ(uplink_.requests[1].share.radius_m, 20);
  uplink_.Share(Others(100, ShareAnew::kEnough - 1));
  EXPECT_EQ(held(), 100u) << "tracking goes on in what it had";
  uplink_.Share(Others(200, 1));
  EXPECT_EQ(held(), ShareAnew::kEnough);
  uplink_.Share(Others(201, 5));
  EXPECT_EQ(held(), ShareAnew::kEnough + 5) << "the rest comes as ever";
}

TEST_F(StoreLinkLocaliseTest, WhereLittleIsNearItIsNotWaitedForLong) {
  const auto link = MakeLink();
  link->Step();
  uplink_.Share(Others(0, 100));
  jobs_.Run(map_);
  link->AskAnew(20);
  link->Step();
  uplink_.Share(Others(100, 2));
  now_ += ShareAnew::kMaxWait;
  link->Step();
  jobs_.Run(map_);
  EXPECT_EQ(link->shared_keyframes(), 2u);
}

TEST_F(StoreLinkLocaliseTest, WithoutASessionTheRobotKeepsWhatItHas) {
  const auto link = MakeLink();
  link->Step();
  uplink_.Share(Others(0, 100));
  jobs_.Run(map_);
  uplink_.reachable = false;
  uplink_.Break(absl::UnavailableError("cut"));
  link->AskAnew(20);
  link->Step();
  jobs_.Run(map_);
  EXPECT_EQ(link->shared_keyframes(), 100u);
}

}  // namespace
}  // namespace corbslam::client_agent
