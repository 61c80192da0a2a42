// Upgrades a mission program by program while two robots drive it, and has programs of two builds
// work together: what robots made must be in the store (docs/upgrade.md).
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "tests/fault/upgrade_fixture.h"

namespace corbslam::tests {

namespace {

// Without older programs the drive is a short one.
std::string Drive(bool reverse) {
  const std::string frames = HasOldPrograms() || WantsLongFaults() ? "" : "frames=0:69";
  return reverse ? absl::StrCat("reverse=1&", frames) : frames;
}

class RollingUpgradeTest : public UpgradeTest {};

TEST_F(RollingUpgradeTest, NothingThatRobotsMadeIsLost) {
  ASSERT_NO_FATAL_FAILURE(StartWorker(Build::kOld));
  ASSERT_NO_FATAL_FAILURE(StartStore(Build::kOld));
  StartRobot(Build::kOld, "alpha", Drive(false));
  StartRobot(Build::kOld, "bravo", Drive(true));
  std::map<std::string, uint64_t> frames = WaitForFrames({});

  End(store_);
  ASSERT_NO_FATAL_FAILURE(StartStore(Build::kNew));
  frames = WaitForFrames(frames);

  End(worker_);
  ASSERT_NO_FATAL_FAILURE(StartWorker(Build::kNew));
  frames = WaitForFrames(frames);

  for (const bool reverse : {true, false}) {
    const std::string agent = reverse ? "alpha" : "bravo";
    EndRobot(agent);
    StartRobot(Build::kNew, agent, Drive(reverse));
    frames = WaitForFrames(frames);
  }
  for (const std::string agent : {"alpha", "bravo"}) {
    const absl::Status ended = WaitForRobot(agent);
    EXPECT_TRUE(ended.ok()) << ended;
  }
  ExpectNothingLost(2);
}

// What an older robot could not send is in its spool, and the newer one sends it.
TEST_F(RollingUpgradeTest, TheSpoolOfTheRobotBeforeIsSent) {
  const std::vector<std::string> spool = {"--spool-dir", FileOf("spool"), "--outbox-mb",
                                          "0",           "--finish",      "5"};
  ASSERT_NO_FATAL_FAILURE(StartWorker(Build::kNew));
  ASSERT_NO_FATAL_FAILURE(StartStore(Build::kOld));
  StartRobot(Build::kOld, "alpha", Drive(false), spool);
  WaitForFrames({});
  End(store_);
  EXPECT_FALSE(WaitForRobot("alpha").ok()) << "it had sent everything";
  ASSERT_EQ(Accounts().size(), 1u);
  EXPECT_GT(Accounts()[0].batches_left, 0u);

  ASSERT_NO_FATAL_FAILURE(StartStore(Build::kNew));
  StartRobot(Build::kNew, "alpha", Drive(true), spool);
  const absl::Status sent = WaitForRobot("alpha");
  EXPECT_TRUE(sent.ok()) << sent;
  ExpectNothingLost(1);
}

// The builds of the robots, the store and the worker.
class MixedBuildsTest : public UpgradeTest,
                        public ::testing::WithParamInterface<std::tuple<Build, Build, Build>> {};

TEST_P(MixedBuildsTest, WorkTogether) {
  const auto [robots, store, worker] = GetParam();
  if (!HasOldPrograms()) GTEST_SKIP() << "CORBSLAM_OLD_PROGRAMS is not set";
  ASSERT_NO_FATAL_FAILURE(StartWorker(worker));
  ASSERT_NO_FATAL_FAILURE(StartStore(store));
  StartRobot(robots, "alpha", "frames=0:69");
  StartRobot(robots, "bravo", "frames=0:69&reverse=1");
  for (const std::string agent : {"alpha", "bravo"}) {
    const absl::Status ended = WaitForRobot(agent);
    EXPECT_TRUE(ended.ok()) << ended;
  }
  ExpectNothingLost(2);
}

std::string NameOf(Build build) { return build == Build::kOld ? "old" : "new"; }

INSTANTIATE_TEST_SUITE_P(RobotsStoreWorker, MixedBuildsTest,
                         ::testing::Combine(::testing::Values(Build::kOld, Build::kNew),
                                            ::testing::Values(Build::kOld, Build::kNew),
                                            ::testing::Values(Build::kOld, Build::kNew)),
                         [](const auto& info) {
                           return absl::StrCat(NameOf(std::get<0>(info.param)), "_",
                                               NameOf(std::get<1>(info.param)), "_",
                                               NameOf(std::get<2>(info.param)));
                         });

}  // namespace
}  // namespace corbslam::tests
