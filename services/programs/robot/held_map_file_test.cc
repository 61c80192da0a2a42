#include "services/programs/robot/held_map_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "services/testing/test_path.h"

namespace corbslam::services {
namespace {

using client_agent::NearMap;
using ::testing::HasSubstr;

TEST(HeldMapFileTest, ComesBackAsItWas) {
  const std::string path = TestPath("held.map");
  NearMap held;
  held.local_map = LocalMapId{0xabc};
  held.own_points = {{1, 2, 3}};
  held.shared_points = {{4, 5, 6}, {7, 8, 9}};
  held.keyframes = {{{LocalMapId{0xdef}, 3}, {}, true}};
  ASSERT_TRUE(WriteHeldMap(held, path).ok());
  const auto read = ReadHeldMap(path);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_TRUE(read->has_value());
  EXPECT_EQ((*read)->shared_points, held.shared_points);
  ASSERT_EQ((*read)->keyframes.size(), 1u);
  EXPECT_EQ((*read)->keyframes[0].id, held.keyframes[0].id);
}

TEST(HeldMapFileTest, ARobotWithoutAPoseHoldsNothing) {
  const std::string path = TestPath("held_nothing.map");
  ASSERT_TRUE(WriteHeldMap(std::nullopt, path).ok());
  const auto read = ReadHeldMap(path);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_FALSE(read->has_value());
}

TEST(HeldMapFileTest, NamesAFileThatIsMissingOrDamaged) {
  EXPECT_EQ(ReadHeldMap("/nowhere/held.map").status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(WriteHeldMap(std::nullopt, "/nowhere/held.map").code(), absl::StatusCode::kUnavailable);
  const std::string path = TestPath("held_damaged.map");
  std::ofstream(path, std::ios::binary) << "no map";
  const absl::Status status = ReadHeldMap(path).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(std::string(status.message()), HasSubstr(path));
}

}  // namespace
}  // namespace corbslam::services
