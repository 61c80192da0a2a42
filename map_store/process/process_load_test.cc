#include "map_store/process/process_load.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace corbslam::map_store {
namespace {

TEST(ProcessLoadTest, ProcessorSecondsGrow) {
  const double before = ProcessorSeconds();
  volatile double sum = 0;
  while (ProcessorSeconds() < before + 0.01) sum = sum + 1;
  EXPECT_GT(sum, 0);
}

TEST(ProcessLoadTest, AControlGroupMayAllowAShareOfAProcessor) {
  const std::string root = ::testing::TempDir() + "process_load";
  EXPECT_GE(UsableProcessors(root + "/nowhere"), 1);
  std::filesystem::create_directories(root + "/sys/fs/cgroup");
  const auto write = [&root](const char* text) {
    std::ofstream(root + "/sys/fs/cgroup/cpu.max") << text;
  };
  write("50000 100000\n");
  EXPECT_EQ(UsableProcessors(root), 0.5);
  write("max 100000\n");
  EXPECT_GE(UsableProcessors(root), 1);
}

}  // namespace
}  // namespace corbslam::map_store
