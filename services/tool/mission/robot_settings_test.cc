#include "services/tool/mission/robot_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "services/security/robot_settings_signature.h"
#include "services/security/testing/token_keys.h"

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

class ToolRobotSettingsTest : public ::testing::Test {
 protected:
  absl::StatusOr<v1::SignedRobotSettings> Make(const RobotSettingsFlags& flags,
                                               const v1::SignedRobotSettings* now,
                                               int64_t unix_s = 1000) {
    return MakeSettings(flags, "lab", "alpha", now, keys_.private_pem,
                        absl::FromUnixSeconds(unix_s));
  }
  v1::RobotSettings Read(const v1::SignedRobotSettings& made) {
    return *VerifyRobotSettings(made, *ReadEd25519PublicKeys("key", keys_.public_pem));
  }
  const test_data::TokenKeys keys_ = test_data::MakeTokenKeys();
};

TEST_F(ToolRobotSettingsTest, WhatIsNotGivenStaysAndVersionsGrow) {
  const auto first =
      Make({.given = {{"features", "1500"}, {"upload", "features=mapped"}, {"uplink-kbps", "0"}}},
           nullptr);
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_EQ(Read(*first).version(), 1000u);
  // By a clock that was set back.
  const auto second = Make({.given = {{"max-rate", "10"}}, .unset = {"upload"}}, &*first, 7);
  ASSERT_TRUE(second.ok()) << second.status();
  const v1::RobotSettings settings = Read(*second);
  EXPECT_EQ(settings.version(), 1001u);
  EXPECT_EQ(settings.mission(), "missions/lab");
  EXPECT_EQ(settings.agent(), "alpha");
  EXPECT_EQ(settings.features(), 1500u);
  EXPECT_EQ(settings.max_frame_rate_hz(), 10);
  EXPECT_FALSE(settings.has_upload_features());
  EXPECT_TRUE(settings.has_uplink_kbps());
  v1::RobotSettingsList list;
  *list.add_settings() = *second;
  EXPECT_EQ(FindSettings(list, "alpha"), &list.settings(0));
  EXPECT_EQ(FindSettings(list, ""), nullptr);
  EXPECT_THAT(FormatSettings(list), HasSubstr("alpha, version 1001\n  features: 1500\n"));
}

// A store must not get signed what nobody wanted.
TEST_F(ToolRobotSettingsTest, WhatAnotherKeySignedIsNotTakenOver) {
  v1::RobotSettings settings;
  settings.set_mission("missions/lab");
  settings.set_agent("alpha");
  settings.set_version(2000);
  settings.set_features(100);
  const auto others = SignRobotSettings(settings, test_data::MakeTokenKeys().private_pem);
  const auto refused = Make({.given = {{"max-rate", "10"}}}, &*others);
  EXPECT_TRUE(absl::IsPermissionDenied(refused.status()));
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("--replace"));
  const auto replaced = Make({.given = {{"max-rate", "10"}}, .replace = true}, &*others);
  ASSERT_TRUE(replaced.ok()) << replaced.status();
  EXPECT_FALSE(Read(*replaced).has_features());
  EXPECT_EQ(Read(*replaced).version(), 2001u);
}

TEST_F(ToolRobotSettingsTest, AVersionFarAheadIsNotFollowed) {
  v1::RobotSettings settings;
  settings.set_mission("missions/lab");
  settings.set_agent("alpha");
  settings.set_version(~uint64_t{0});
  const auto far = SignRobotSettings(settings, keys_.private_pem);
  EXPECT_TRUE(absl::IsFailedPrecondition(Make({.replace = true}, &*far).status()));
}

TEST_F(ToolRobotSettingsTest, WhatCannotBeReadIsRefusedByName) {
  EXPECT_THAT(std::string(Make({.unset = {"colour"}}, nullptr).status().message()),
              HasSubstr("--unset is colour"));
  const std::string no_mask = ::testing::TempDir() + "/no_mask.png";
  std::ofstream(no_mask) << "no picture";
  EXPECT_THAT(std::string(Make({.given = {{"mask", no_mask}}}, nullptr).status().message()),
              HasSubstr("no_mask.png: can't be decoded"));
  EXPECT_THAT(std::string(Make({.given = {{"mask", "/nowhere.png"}}}, nullptr).status().message()),
              HasSubstr("/nowhere.png"));
}

}  // namespace
}  // namespace corbslam::services
