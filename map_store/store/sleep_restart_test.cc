// Tests what a store's start makes of missions that were asleep, or could have been.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "map_store/rocks/summary_file.h"
#include "map_store/testing/sleeping_store.h"
#include "map_store/testing/store_dump.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;
using testing::DumpLocal;
using testing::FirstDifference;
using testing::TestAgent;

class SleepRestartTest : public testing::SleepingStore {
 protected:
  // Opens the store again and returns how many missions that reads.
  int OpenAgain() {
    store_.reset();
    const int reads = counts_.reads_with_features;
    Open();
    return counts_.reads_with_features - reads;
  }
  fs::path Summary() const { return FolderOf() / kSummaryFile; }
};

TEST_F(SleepRestartTest, WhatSleepsIsNotRead) {
  Fill(kMission, map_a_);
  const std::string local = DumpLocal(kMission, *store_);
  ASSERT_TRUE(store_->SleepMission(kMission).ok());
  const MissionInfo before = *store_->GetMission(kMission);
  EXPECT_EQ(OpenAgain(), 0);
  const MissionInfo after = *store_->GetMission(kMission);
  EXPECT_TRUE(after.asleep);
  EXPECT_EQ(after.keyframes, before.keyframes);
  EXPECT_EQ(after.profile.last_used_ns, before.profile.last_used_ns);
  EXPECT_EQ(FirstDifference(DumpLocal(kMission, *store_), local), "");
}

TEST_F(SleepRestartTest, AnOrderlyEndSavesReading) {
  Fill(kMission, map_a_);
  Fill("other", map_b_);
  TestAgent left_behind(*store_, "other", "late", map_a_);
  EXPECT_EQ(OpenAgain(), 0);
  EXPECT_EQ(store_->sleep().asleep, 2u);
  EXPECT_EQ(store_->GetMission("other")->agents, 2u);
}

TEST_F(SleepRestartTest, WithoutSleepAllAreRead) {
  Fill(kMission, map_a_);
  options_.sleep_after_s = 0;
  EXPECT_EQ(OpenAgain(), 1);
  EXPECT_FALSE(IsAsleep());
  EXPECT_EQ(OpenAgain(), 1) << "no summary was written";
  ASSERT_TRUE(store_->SleepMission(kMission).ok()) << "who asks for it gets it";
  EXPECT_TRUE(IsAsleep());
}

TEST_F(SleepRestartTest, ADamagedSummaryHasTheMissionRead) {
  Fill(kMission, map_a_);
  const std::string local = DumpLocal(kMission, *store_);
  store_.reset();
  const uint64_t size = fs::file_size(Summary());
  {
    std::fstream file(Summary(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(size / 2));
    file.put('\xa5');
  }
  EXPECT_EQ(OpenAgain(), 1);
  EXPECT_FALSE(IsAsleep());
  EXPECT_EQ(FirstDifference(DumpLocal(kMission, *store_), local), "");
  store_.reset();
  fs::remove(Summary());
  EXPECT_EQ(OpenAgain(), 1);
  store_.reset();
  fs::resize_file(Summary(), 3);
  EXPECT_EQ(OpenAgain(), 1);
}

// The folder is as a store would find it that was killed, or after another program has used it.
TEST_F(SleepRestartTest, AnOldSummaryIsNotBelieved) {
  Fill(kMission, map_a_);
  store_.reset();
  const fs::path kept = folder_ / "kept_summary";
  fs::copy_file(Summary(), kept);
  Open();
  TestAgent robot(*store_, kMission, "newcomer", map_b_);
  ASSERT_TRUE(robot.Stream(2).ok());
  EXPECT_FALSE(fs::exists(Summary())) << "a mission in use has none";
  store_.reset();
  fs::copy_file(kept, Summary(), fs::copy_options::overwrite_existing);
  EXPECT_EQ(OpenAgain(), 1);
  EXPECT_EQ(store_->GetMission(kMission)->keyframes, 16u);
}

TEST_F(SleepRestartTest, WorkForFusionHasTheMissionRead) {
  {
    TestAgent a(*store_, kMission, "a", map_a_);
    TestAgent b(*store_, kMission, "b", map_b_);
    ASSERT_TRUE(a.Stream().ok() && b.Stream().ok());
    ASSERT_TRUE(a.Close().ok() && b.Close().ok());
  }
  EXPECT_EQ(OpenAgain(), 0) << "without a worker nothing can be done";
  EXPECT_TRUE(IsAsleep());
  worker_ = &truthful_;
  EXPECT_EQ(OpenAgain(), 1);
  EXPECT_FALSE(*store_->IsFusionIdle(kMission));
  EXPECT_TRUE(absl::IsFailedPrecondition(store_->SleepMission(kMission)));
  EXPECT_EQ(OpenAgain(), 1) << "it would have to be read anyway";
  ASSERT_TRUE(store_->RunFusionUntilIdle(kMission).ok());
  EXPECT_EQ(OpenAgain(), 0);
  EXPECT_EQ(store_->GetMission(kMission)->islands, 1u);
}

// Two joined sessions, of which all has retired that may.
class RetiredMissionTest : public SleepRestartTest {
 protected:
  RetiredMissionTest() {
    options_.retire = true;
    worker_ = &truthful_;
    Open();
    TestAgent a(*store_, kMission, "a", map_a_);
    TestAgent b(*store_, kMission, "b", map_b_);
    EXPECT_TRUE(a.Stream().ok() && b.Stream().ok());
    EXPECT_TRUE(a.Close().ok() && b.Close().ok());
    store_->CloseSession(a.session());
    store_->CloseSession(b.session());
    EXPECT_TRUE(store_->RunFusionUntilIdle(kMission).ok());
  }
  // Reads the mission if it sleeps.
  bool IsIdleAwake() {
    EXPECT_TRUE(
        store_->GetLocalMap(kMission, map_a_.map.keyframes().begin()->first.local_map).ok());
    EXPECT_FALSE(IsAsleep());
    return *store_->IsFusionIdle(kMission);
  }
};

TEST_F(RetiredMissionTest, WakesWithNothingToLookAt) {
  ASSERT_TRUE(IsIdleAwake());
  ASSERT_TRUE(store_->SleepMission(kMission).ok());
  EXPECT_TRUE(IsIdleAwake());
  EXPECT_EQ(OpenAgain(), 0);
  EXPECT_TRUE(IsIdleAwake()) << "the summary says it after a restart, too";
}

TEST_F(RetiredMissionTest, IsLookedAtWhereAStoreKeptEverythingBefore) {
  options_.retire = false;
  Open();
  ASSERT_TRUE(IsIdleAwake());
  options_.retire = true;
  OpenAgain();
  EXPECT_FALSE(IsIdleAwake());
  ASSERT_TRUE(store_->RunFusionUntilIdle(kMission).ok());
  EXPECT_TRUE(IsIdleAwake());
}

}  // namespace
}  // namespace corbslam::map_store
