#include "services/server/memory_limit.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace corbslam::services {
namespace {

class MemoryLimitTest : public ::testing::Test {
 protected:
  // Files of an earlier run must not be seen.
  void SetUp() override { std::filesystem::remove_all(root_); }
  void Write(const std::string& file, const std::string& text) {
    const std::filesystem::path path = root_ + file;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }

  const std::string root_ = ::testing::TempDir() + "memory_limit_" +
                            ::testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST_F(MemoryLimitTest, IsTheMachinesWhereNothingElseIsSaid) {
  EXPECT_GT(MemoryLimitBytes(root_), 64u << 20);
  Write("/sys/fs/cgroup/memory.max", "max\n");
  EXPECT_GT(MemoryLimitBytes(root_), 64u << 20);
}

TEST_F(MemoryLimitTest, IsTheContainers) {
  Write("/sys/fs/cgroup/memory.max", "50000000\n");
  EXPECT_EQ(MemoryLimitBytes(root_), 50'000'000u);
}

TEST_F(MemoryLimitTest, IsTheLeastOfTheGroupsAroundTheProcess) {
  Write("/proc/self/cgroup", "0::/system.slice/map_store.service\n");
  Write("/sys/fs/cgroup/system.slice/map_store.service/memory.max", "60000000\n");
  EXPECT_EQ(MemoryLimitBytes(root_), 60'000'000u);
  Write("/sys/fs/cgroup/system.slice/memory.max", "50000000\n");
  EXPECT_EQ(MemoryLimitBytes(root_), 50'000'000u);
}

TEST_F(MemoryLimitTest, KnowsVersionOne) {
  Write("/proc/self/cgroup", "4:memory:/docker/abc\n");
  Write("/sys/fs/cgroup/memory/memory.limit_in_bytes", "40000000\n");
  EXPECT_EQ(MemoryLimitBytes(root_), 40'000'000u);
}

TEST_F(MemoryLimitTest, ALimitLargerThanTheMachineIsNone) {
  const uint64_t machine = MemoryLimitBytes(root_);
  Write("/sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
  EXPECT_EQ(MemoryLimitBytes(root_), machine);
}

}  // namespace
}  // namespace corbslam::services
