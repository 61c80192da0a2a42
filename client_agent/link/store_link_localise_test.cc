// Tests the link of a robot that only localises.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "client_agent/link/store_link.h"
#include "client_agent/link/testing/fake_map_jobs.h"
#include "client_agent/link/testing/localising_uplink.h"
#include "client_agent/link/testing/test_payload.h"
#include "gtest/gtest.h"

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

constexpr LocalMapId kGuestsMap{1};

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
  const int64_t frames = LocalisedOutbox::kMaxPlaces + 10;
  for (int64_t i = 0; i < frames; ++i) link->AddLocalised({i, Rigid3d::Identity()});
  uplink_.reachable = true;
  uplink_.takes = false;
  link->Step();
  EXPECT_TRUE(uplink_.localised.empty());
  uplink_.takes = true;
  link->Step();
  ASSERT_EQ(uplink_.localised.size(), LocalisedOutbox::kMaxPlaces);
  EXPECT_EQ(uplink_.localised.back().timestamp_ns, frames - 1);
}

class StoreLinkTrajectoryTest : public StoreLinkLocaliseTest {
 protected:
  StoreLinkTrajectoryTest() { uplink_.capabilities.keeps_localised = true; }
  static TrackedFrame Frame(int64_t time_ns) { return {time_ns, {{2}, 0}, Rigid3d::Identity()}; }
  // Lets the link send, and hears its answers.
  void Pass(StoreLink& link, absl::Duration time = absl::Seconds(2)) {
    now_ += time;
    link.Step();
  }
};

TEST_F(StoreLinkTrajectoryTest, ItGoesUpInPartsAndOnlyTheNewestPlaceBesides) {
  const auto link = MakeLink();
  link->Step();
  for (int64_t i = 1; i <= 3; ++i) {
    link->AddTrackedFrame(Frame(i));
    link->AddLocalised({i, Rigid3d::Identity()});
  }
  link->AddLostFrame(4);
  link->AddLocalised({4, std::nullopt});
  Pass(*link);
  EXPECT_THAT(uplink_.Kept(), ElementsAre(1, 2, 3, -4));
  EXPECT_EQ(link->upload().frames, 0u);
  EXPECT_EQ(uplink_.localised.size(), 2u);
  link->AddTrackedFrame(Frame(5));
  EXPECT_EQ(link->upload().frames, 1u) << "it waits, and the robot's status says so";
  EXPECT_TRUE(link->Finish(absl::Seconds(1)).ok());
  EXPECT_THAT(uplink_.Kept(), ElementsAre(1, 2, 3, -4, 5));
  EXPECT_EQ(uplink_.runs.size(), 1u);
}

TEST_F(StoreLinkTrajectoryTest, WhatWasNotAnsweredGoesAgainAfterABreakWithTheSameNumber) {
  const auto link = MakeLink();
  link->Step();
  uplink_.keeps_now = false;
  link->AddTrackedFrame(Frame(1));
  Pass(*link);
  uplink_.Break(absl::UnavailableError("cut"));
  link->AddTrackedFrame(Frame(2));
  uplink_.keeps_now = true;
  Pass(*link);
  ASSERT_EQ(uplink_.parts.size(), 3u);
  EXPECT_EQ(uplink_.parts[0].number, 1u);
  EXPECT_EQ(uplink_.parts[1].number, 1u);
  EXPECT_EQ(uplink_.parts[1].run, uplink_.parts[0].run);
  EXPECT_THAT(uplink_.Kept(), ElementsAre(1, 2));
}

TEST_F(StoreLinkTrajectoryTest, AStoreWithoutRoomIsAskedAgainInTheSameSession) {
  const auto link = MakeLink();
  link->Step();
  uplink_.keeps_now = false;
  link->AddTrackedFrame(Frame(1));
  Pass(*link);
  Pass(*link, absl::Seconds(5));
  EXPECT_EQ(uplink_.parts.size(), 1u) << "it has patience";
  const absl::Status unkept = link->Finish(absl::ZeroDuration());
  EXPECT_TRUE(absl::IsDeadlineExceeded(unkept)) << unkept;
  EXPECT_THAT(std::string(unkept.message()), HasSubstr("1 frames of the trajectory"));
  uplink_.keeps_now = true;
  Pass(*link, LocalisedOutbox::kPatience + absl::Seconds(1));
  EXPECT_THAT(uplink_.Kept(), ElementsAre(1));
  EXPECT_EQ(uplink_.requests.size(), 1u);
  EXPECT_TRUE(link->Finish(absl::Seconds(1)).ok());
}

TEST_F(StoreLinkTrajectoryTest, WhatASlowLinkHasNotCarriedYetDoesNotGoTwice) {
  const auto link = MakeLink();
  link->Step();
  uplink_.keeps_now = false;
  link->AddTrackedFrame(Frame(1));
  uplink_.waiting = 1000;
  Pass(*link);
  Pass(*link, LocalisedOutbox::kPatience + absl::Seconds(1));
  Pass(*link, LocalisedOutbox::kPatience + absl::Seconds(1));
  EXPECT_EQ(uplink_.parts.size(), 1u);
  uplink_.waiting = 0;
  Pass(*link);
  uplink_.keeps_now = true;
  Pass(*link, LocalisedOutbox::kPatience + absl::Seconds(1));
  EXPECT_EQ(uplink_.parts.size(), 2u);
  EXPECT_THAT(uplink_.Kept(), ElementsAre(1));
}

// A store would end the session for it, for good.
TEST_F(StoreLinkTrajectoryTest, APoseThatMeansNothingIsALoss) {
  const auto link = MakeLink();
  link->Step();
  Rigid3d nowhere;
  nowhere.translation.x() = std::numeric_limits<double>::quiet_NaN();
  link->AddTrackedFrame({1, {{2}, 0}, nowhere});
  link->AddLocalised({1, nowhere});
  link->AddLostFrame(-1);
  link->AddTrackedFrame(Frame(2));
  Pass(*link);
  EXPECT_THAT(uplink_.Kept(), ElementsAre(2, -1));
  ASSERT_EQ(uplink_.localised.size(), 1u);
  EXPECT_FALSE(uplink_.localised[0].camera_from_global.has_value());
}

TEST_F(StoreLinkTrajectoryTest, SoManyPartsWaitAtMost) {
  const auto link = MakeLink();
  link->Step();
  uplink_.keeps_now = false;
  const auto parts = static_cast<int64_t>(LocalisedOutbox::kMaxParts);
  for (int64_t i = 1; i <= parts + 5; ++i) {
    link->AddTrackedFrame(Frame(i));
    now_ += absl::Milliseconds(1);
    Pass(*link, absl::Seconds(1));
    uplink_.Break(absl::UnavailableError("cut"));
    link->Step();
  }
  uint64_t highest = 0;
  for (const LocalisedFrames& part : uplink_.parts) highest = std::max(highest, part.number);
  EXPECT_EQ(highest, LocalisedOutbox::kMaxParts);
  uplink_.keeps_now = true;
  Pass(*link);
  Pass(*link);
  EXPECT_EQ(uplink_.Kept().size(), static_cast<size_t>(parts) + 5);
}

TEST_F(StoreLinkTrajectoryTest, AStoreThatHasLostWhatItKeptGetsTheRestInAnotherRun) {
  const auto link = MakeLink();
  link->Step();
  for (int64_t i = 1; i <= 3; ++i) {
    link->AddTrackedFrame(Frame(i));
    Pass(*link);
  }
  ASSERT_EQ(uplink_.runs.size(), 1u);
  uplink_.runs.begin()->second.resize(1);
  link->AddTrackedFrame(Frame(4));
  Pass(*link);
  Pass(*link);
  EXPECT_EQ(uplink_.runs.size(), 2u);
  EXPECT_THAT(uplink_.Kept(), UnorderedElementsAre(1, 4));
}

TEST_F(StoreLinkTrajectoryTest, AnOlderStoreKeepsNoneAndNothingWaitsForIt) {
  uplink_.capabilities.keeps_localised = false;
  const auto link = MakeLink();
  link->Step();
  link->AddTrackedFrame(Frame(1));
  link->AddLocalised({1, Rigid3d::Identity()});
  Pass(*link);
  EXPECT_TRUE(uplink_.parts.empty());
  EXPECT_EQ(uplink_.localised.size(), 1u);
  EXPECT_TRUE(link->Finish(absl::Seconds(1)).ok());
}

TEST(LocalisedOutboxTest, WithoutRoomTheOldestGoesAndTheGapIsTold) {
  LocalisedOutbox outbox(/*max_bytes=*/0, /*seed=*/1, std::nullopt);
  LocalisingUplink uplink;
  uplink.open = true;
  // A camera that is lost for long takes no room from what was tracked.
  outbox.AddTracked({1, {{2}, 0}, {}});
  for (int64_t i = 2; i < 5000; ++i) outbox.AddLost(i);
  EXPECT_EQ(outbox.dropped(), 0u);
  for (int64_t i = 5000; i < 6000; ++i) outbox.AddTracked({i, {{2}, 0}, {}});
  EXPECT_GT(outbox.dropped(), 0u);
  EXPECT_EQ(outbox.CountUnkept() + outbox.dropped(), 1001u);
  outbox.BeginSession(/*keeps=*/true);
  uplink.keeps_now = false;
  LinkBudget unbounded(0);
  outbox.SendTo(uplink, unbounded, absl::ZeroDuration(), absl::UnixEpoch());
  ASSERT_EQ(uplink.parts.size(), 1u);
  ASSERT_FALSE(uplink.parts[0].lost_frames_ns.empty());
  EXPECT_LT(uplink.parts[0].lost_frames_ns.back(),
            uplink.parts[0].tracked_frames.front().timestamp_ns);
  EXPECT_EQ(uplink.parts[0].tracked_frames.back().timestamp_ns, 5999);
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
