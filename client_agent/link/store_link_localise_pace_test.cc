// Tests how fast a robot that only localises says its trajectory: within the budget of its link,
// and again, where the store has no room, after ever longer waits.
#include <gmock/gmock.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "client_agent/link/store_link.h"
#include "client_agent/link/testing/fake_map_jobs.h"
#include "client_agent/link/testing/localising_uplink.h"
#include "gtest/gtest.h"

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

constexpr LocalMapId kPacedGuestsMap{1};
constexpr uint64_t kGuestBytesPerSecond = 1000;

class StoreLinkLocalisePaceTest : public ::testing::Test {
 protected:
  StoreLinkLocalisePaceTest() {
    uplink_.capabilities.localise_only = true;
    uplink_.capabilities.keeps_localised = true;
    options_.mission = "m";
    options_.agent = "guest";
    options_.localise_only = true;
    options_.min_backoff = options_.max_backoff = absl::ZeroDuration();
    options_.clock = [this] { return now_; };
  }

  void StartGuest(uint64_t bytes_per_second = 0) {
    options_.uplink_bytes_per_second = bytes_per_second;
    link_ = std::make_unique<StoreLink>(options_, &uplink_,
                                        [](const auto&) { return std::make_shared<Words>(); });
    link_->BeginLocalMap(map_, jobs_);
    link_->Step();
  }
  void AddFrame() {
    ++frames_;
    link_->AddTrackedFrame({frames_, {{2}, 0}, Rigid3d::Identity()});
    link_->AddLocalised({frames_, Rigid3d::Identity()});
  }
  // Steps the link ten times a second for so long, with three frames each time if it drives.
  void Run(absl::Duration length, bool drives) {
    for (const absl::Time end = now_ + length; now_ < end; now_ += absl::Milliseconds(100)) {
      for (int i = 0; drives && i < 3; ++i) AddFrame();
      link_->Step();
    }
  }
  // Steps the link once a second for so long; returns after how many seconds a part came, and how
  // many seconds lie between one and the next.
  std::vector<int> WatchParts(int seconds) {
    std::vector<int> after;
    int last = 0;
    for (int second = 1; second <= seconds; ++second) {
      const size_t before = uplink_.parts.size();
      now_ += absl::Seconds(1);
      link_->Step();
      if (uplink_.parts.size() == before) continue;
      after.push_back(second - last);
      last = second;
    }
    return after;
  }

  const absl::Time start_ = absl::UnixEpoch() + absl::Hours(1);
  absl::Time now_ = start_;
  LocalisingUplink uplink_;
  FakeMapJobs jobs_;
  GuardedMap map_{kPacedGuestsMap};
  StoreLinkOptions options_;
  int64_t frames_ = 0;
  std::unique_ptr<StoreLink> link_;
};

TEST_F(StoreLinkLocalisePaceTest, TheTrajectoryKeepsToTheBudgetAndIsWholeInTheEnd) {
  StartGuest(kGuestBytesPerSecond);
  constexpr double kDriven_s = 20;
  Run(absl::Seconds(kDriven_s), /*drives=*/true);
  ASSERT_GT(48 * frames_, static_cast<int64_t>(kDriven_s * kGuestBytesPerSecond));
  const size_t kept = uplink_.Kept().size();
  EXPECT_GT(kept, 200u);
  EXPECT_LT(kept, static_cast<size_t>(frames_));
  // What fills in a second comes besides, and the last part is paid for afterwards.
  EXPECT_LE(static_cast<double>(uplink_.bytes), (kDriven_s + 2.5) * kGuestBytesPerSecond);
  // Of the places only the newest go, with the parts.
  EXPECT_LE(uplink_.localised.size(), uplink_.parts.size());
  Run(absl::Seconds(30), /*drives=*/false);
  const std::vector<int64_t> times = uplink_.Kept();
  ASSERT_EQ(times.size(), static_cast<size_t>(frames_));
  EXPECT_TRUE(std::ranges::is_sorted(times));
  EXPECT_EQ(uplink_.localised.back().timestamp_ns, frames_);
}

TEST_F(StoreLinkLocalisePaceTest, WhatGoesASecondTimeKeepsToItToo) {
  StartGuest(kGuestBytesPerSecond);
  uplink_.keeps_now = false;
  Run(absl::Seconds(10), /*drives=*/true);
  const uint64_t before = uplink_.bytes;
  uplink_.Break(absl::UnavailableError("cut"));
  Run(absl::Seconds(1), /*drives=*/false);
  EXPECT_LE(uplink_.bytes - before, 2.5 * kGuestBytesPerSecond);
  Run(absl::Seconds(9), /*drives=*/false);
  EXPECT_LE(uplink_.bytes - before, 11.5 * kGuestBytesPerSecond);
}

TEST_F(StoreLinkLocalisePaceTest, ALinkThatIsSlowerThanItsBudgetIsNotGivenMore) {
  StartGuest(100 * kGuestBytesPerSecond);
  AddFrame();
  Run(absl::Seconds(1), /*drives=*/false);
  uplink_.waiting = 1;
  AddFrame();
  Run(absl::Seconds(1), /*drives=*/false);
  EXPECT_EQ(uplink_.Kept().size(), 1u);
  uplink_.waiting = 0;
  Run(absl::Seconds(1), /*drives=*/false);
  EXPECT_EQ(uplink_.Kept().size(), 2u);
}

TEST_F(StoreLinkLocalisePaceTest, AnOlderStoreIsToldTheNewestPlaceWithinTheBudget) {
  uplink_.capabilities.keeps_localised = false;
  StartGuest(kGuestBytesPerSecond);
  for (int i = 0; i < 1000; ++i) AddFrame();
  Run(absl::Seconds(1), /*drives=*/false);
  ASSERT_EQ(uplink_.localised.size(), 1u);
  EXPECT_EQ(uplink_.localised[0].timestamp_ns, 1000);
}

TEST_F(StoreLinkLocalisePaceTest, WhoWaitsTooShortIsToldOfTheBudget) {
  StartGuest(kGuestBytesPerSecond);
  for (int i = 0; i < 1000; ++i) AddFrame();
  const absl::Status unfinished = link_->Finish(absl::ZeroDuration());
  ASSERT_TRUE(absl::IsDeadlineExceeded(unfinished)) << unfinished;
  EXPECT_THAT(std::string(unfinished.message()),
              HasSubstr("frames of the trajectory; held back by a budget of 1000 bytes a second)"));
  link_->SetUplinkRate(0);
  EXPECT_TRUE(link_->Finish(absl::ZeroDuration()).ok());
  EXPECT_EQ(uplink_.Kept().size(), 1000u);
}

TEST_F(StoreLinkLocalisePaceTest, AStoreWithoutRoomIsAskedEverMoreSeldom) {
  StartGuest();
  uplink_.keeps_now = false;
  AddFrame();
  const std::vector<int> after = WatchParts(1000);
  ASSERT_GE(after.size(), 7u);
  EXPECT_LE(after.size(), 15u);
  EXPECT_EQ(after[0], 1);
  // A step comes a second late at most.
  int longest_s = 10;
  for (size_t i = 1; i < after.size(); ++i) {
    EXPECT_GE(after[i], longest_s / 2) << i;
    EXPECT_LE(after[i], longest_s + 2) << i;
    longest_s = std::min(2 * longest_s, 160);
  }
  // Once it has room, the next part that it does not answer goes as soon as the first did.
  uplink_.keeps_now = true;
  EXPECT_EQ(WatchParts(162).size(), 1u);
  EXPECT_EQ(uplink_.Kept().size(), 1u);
  uplink_.keeps_now = false;
  AddFrame();
  EXPECT_GE(WatchParts(13).size(), 2u);
}

TEST_F(StoreLinkLocalisePaceTest, AtItsEndTheRobotDoesNotWaitThatLong) {
  StartGuest();
  uplink_.keeps_now = false;
  AddFrame();
  while (WatchParts(50).size() > 0) {
  }
  uplink_.keeps_now = true;
  EXPECT_TRUE(link_->Finish(absl::Seconds(1)).ok());
  EXPECT_EQ(uplink_.Kept().size(), 1u);
}

}  // namespace
}  // namespace corbslam::client_agent
