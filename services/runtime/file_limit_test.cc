#include "services/runtime/file_limit.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

namespace corbslam::services {
namespace {

TEST(FileLimitTest, HalfOfTheFilesStayForAllElse) {
  EXPECT_EQ(LimitsWithin(1 << 20).all, ConnectionLimits().all);
  EXPECT_EQ(LimitsWithin(1 << 20).of_host, ConnectionLimits().of_host);
  EXPECT_EQ(LimitsWithin(1024).all, 512u);
  EXPECT_EQ(LimitsWithin(1024).of_host, 128u);
  EXPECT_EQ(LimitsWithin(300).all, 150u);
  EXPECT_EQ(LimitsWithin(300).of_host, 64u);
  EXPECT_EQ(LimitsWithin(64).of_host, 32u);
  EXPECT_EQ(LimitsWithin(0).all, 4u);
}

TEST(FileLimitTest, TheLimitIsRaisedToTheHardOne) {
  rlimit before = {};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  rlimit low = before;
  low.rlim_cur = 64;
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &low), 0);
  EXPECT_EQ(FileLimit(), 64u);
  RaiseFileLimit();
  rlimit after = {};
  getrlimit(RLIMIT_NOFILE, &after);
  EXPECT_GT(after.rlim_cur, 64u);
  setrlimit(RLIMIT_NOFILE, &before);
}

}  // namespace
}  // namespace corbslam::services
