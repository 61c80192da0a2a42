#include "map_store/process/backup_keeper.h"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

namespace corbslam::map_store {
namespace {

class BackupKeeperTest : public ::testing::Test {
 protected:
  BackupKeeper keeper_{absl::Hours(1), [this] { return now_; },
                       [this]() -> absl::StatusOr<std::vector<std::string>> { return missions_; },
                       [this](const std::string& mission) -> absl::StatusOr<bool> {
                         asked_.push_back(mission);
                         if (const auto it = errors_.find(mission); it != errors_.end()) {
                           return it->second;
                         }
                         return mission != "idle";
                       }};
  absl::Time now_ = absl::FromUnixSeconds(1'800'000'000);
  std::vector<std::string> missions_ = {"a", "b", "idle"};
  std::map<std::string, absl::Status> errors_;
  std::vector<std::string> asked_;
};

TEST_F(BackupKeeperTest, ARoundIsDueAtOnceAndThenAtEachInterval) {
  EXPECT_EQ(keeper_.RunIfDue(), now_ + absl::Hours(1));
  EXPECT_EQ(asked_.size(), 3u);
  EXPECT_EQ(keeper_.counts().made, 2u);
  EXPECT_EQ(keeper_.counts().unchanged, 1u);
  EXPECT_EQ(keeper_.counts().all_safe_at, now_);
  now_ += absl::Minutes(59);
  EXPECT_EQ(keeper_.RunIfDue(), now_ + absl::Minutes(1));
  EXPECT_EQ(asked_.size(), 3u);
  now_ += absl::Minutes(1);
  keeper_.RunIfDue();
  EXPECT_EQ(asked_.size(), 6u);
}

TEST_F(BackupKeeperTest, AClockThatIsSetBackPutsNothingOff) {
  keeper_.RunIfDue();
  now_ -= absl::Hours(100);
  keeper_.RunIfDue();
  EXPECT_EQ(asked_.size(), 6u);
}

TEST_F(BackupKeeperTest, AnErrorIsOneMissionsAndIsTriedAgain) {
  errors_["a"] = absl::ResourceExhaustedError("no room");
  const absl::Time first = now_;
  keeper_.RunIfDue();
  EXPECT_EQ(asked_.size(), 3u) << "the others have theirs";
  EXPECT_EQ(keeper_.counts().failed, 1u);
  EXPECT_EQ(keeper_.counts().failing.at("a"), "no room");
  EXPECT_EQ(keeper_.counts().all_safe_at, absl::InfinitePast());
  errors_.clear();
  now_ += absl::Hours(1);
  keeper_.RunIfDue();
  EXPECT_TRUE(keeper_.counts().failing.empty());
  EXPECT_EQ(keeper_.counts().all_safe_at, first + absl::Hours(1));
}

TEST_F(BackupKeeperTest, AMissionThatIsDeletedIsNoError) {
  errors_["a"] = absl::NotFoundError("gone");
  errors_["b"] = absl::UnavailableError("the disk refuses");
  keeper_.RunIfDue();
  EXPECT_EQ(keeper_.counts().failed, 1u);
  missions_ = {"idle"};
  now_ += absl::Hours(1);
  keeper_.RunIfDue();
  EXPECT_TRUE(keeper_.counts().failing.empty()) << "nobody wants to know of b any more";
}

TEST_F(BackupKeeperTest, TheThreadEndsWhenItIsTold) {
  keeper_.Start();
  keeper_.Stop();
}

}  // namespace
}  // namespace corbslam::map_store
