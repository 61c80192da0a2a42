#include "services/convert/robot_setting_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

v1::RobotSettings Settings() {
  v1::RobotSettings settings;
  settings.set_mission("missions/lab");
  settings.set_version(1);
  return settings;
}

using Change = std::function<void(v1::RobotSettings&)>;

absl::Status Check(const Change& change) {
  v1::RobotSettings settings = Settings();
  change(settings);
  return CheckRobotSettings(settings);
}

// One header of a PNG of 2x1 pixels, with the mark of its end and nothing between.
std::string SmallPng() {
  std::string png("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\2\0\0\0\1\10\0\0\0\0", 29);
  return png + std::string("\0\0\0\0\0\0\0\0IEND\xae\x42\x60\x82", 16);
}

TEST(RobotSettingTableTest, WhatARobotCanRunWithPasses) {
  const std::vector<Change> good = {
      [](auto&) {},
      [](auto& s) { s.set_features(50); },
      [](auto& s) { s.set_features(20'000); },
      [](auto& s) { s.set_max_frame_rate_hz(0); },
      [](auto& s) { s.set_max_frame_rate_hz(0.1); },
      [](auto& s) { s.set_memory_budget_bytes(0); },
      [](auto& s) { s.set_memory_budget_bytes(kLeastMemoryBudget_bytes); },
      [](auto& s) { s.set_upload_features("20000"); },
      [](auto& s) { s.set_uplink_kbps(8); },
      [](auto& s) { s.set_share_radius_m(1); },
      [](auto& s) { s.set_share("nearby"), s.set_share_radius_m(1e6); },
      [](auto& s) { s.set_share("nearby"), s.set_memory_budget_bytes(uint64_t{1} << 30); },
      [](auto& s) { s.set_mask_png(SmallPng()); },
      [](auto& s) { s.set_mask_png(""); },
  };
  for (const Change& change : good) EXPECT_TRUE(Check(change).ok()) << Check(change);
}

TEST(RobotSettingTableTest, EachFieldHasItsBoundsAndSaysThem) {
  struct Case {
    Change change;
    std::vector<std::string> says;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<Case> cases = {
      {[](auto& s) { s.set_features(0); }, {"features is 0", "50 to 20000"}},
      {[](auto& s) { s.set_features(1); }, {"features is 1", "50 to 20000"}},
      {[](auto& s) { s.set_features(49); }, {"features is 49", "50 to 20000"}},
      {[](auto& s) { s.set_features(1'000'000); }, {"features is 1000000", "50 to 20000"}},
      {[](auto& s) { s.set_features(0xffffffff); }, {"features is 4294967295", "50 to 20000"}},
      {[](auto& s) { s.set_max_frame_rate_hz(0.01); }, {"max_frame_rate_hz is 0.01", "0.1 to"}},
      {[](auto& s) { s.set_max_frame_rate_hz(-1); }, {"max_frame_rate_hz is -1"}},
      {[=](auto& s) { s.set_max_frame_rate_hz(nan); }, {"max_frame_rate_hz is nan"}},
      {[=](auto& s) { s.set_max_frame_rate_hz(infinity); }, {"max_frame_rate_hz is inf"}},
      {[](auto& s) { s.set_memory_budget_bytes(1); }, {"memory_budget_bytes is 1", "MiB"}},
      {[](auto& s) { s.set_memory_budget_bytes(~uint64_t{0}); }, {"memory_budget_bytes is 184467"}},
      {[](auto& s) { s.set_upload_features("0"); }, {"upload_features is 0", "1 to 20000"}},
      {[](auto& s) { s.set_upload_features("20001"); }, {"upload_features is 20001"}},
      {[](auto& s) { s.set_upload_features("features=all"); }, {"upload_features is features=all"}},
      {[](auto& s) { s.set_upload_features(""); }, {"upload_features is ,"}},
      {[](auto& s) { s.set_share("all"); }, {"share is all", "everything"}},
      {[=](auto& s) { s.set_share_radius_m(nan); }, {"share_radius_m is nan"}},
      {[](auto& s) { s.set_share_radius_m(0.5); }, {"share_radius_m is 0.5", "1 to 1e+06"}},
      {[](auto& s) { s.set_share("none"), s.set_share_radius_m(5); }, {"share = nearby"}},
      {[](auto& s) { s.set_uplink_kbps(7); }, {"uplink_kbps is 7"}},
      {[](auto& s) { s.set_uplink_kbps(10'000'001); }, {"uplink_kbps is 10000001"}},
      {[](auto& s) { s.set_share("everything"), s.set_memory_budget_bytes(uint64_t{1} << 30); },
       {"memory_budget_bytes", "share = everything"}},
      {[](auto& s) { s.set_mask_png("no picture"); }, {"mask_png is 10 bytes"}},
      {[](auto& s) { s.set_mask_png(SmallPng().substr(0, 30)); }, {"mask_png is 30 bytes"}},
      {[](auto& s) { s.set_version(0); }, {"version is 0"}},
  };
  for (const Case& wrong : cases) {
    const absl::Status status = Check(wrong.change);
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << wrong.says[0] << ": " << status;
    for (const std::string& says : wrong.says) {
      EXPECT_THAT(std::string(status.message()), HasSubstr(says));
    }
  }
}

}  // namespace
}  // namespace corbslam::services
