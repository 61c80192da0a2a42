#include "services/programs/settings_flags.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

v1::RobotSettings OfAll() {
  v1::RobotSettings settings;
  settings.set_mission("missions/lab");
  settings.set_version(4);
  settings.set_features(1500);
  settings.set_uplink_kbps(800);
  return settings;
}

TEST(SettingsFlagsTest, TheRobotsOwnGoBeforeThoseOfAll) {
  v1::RobotSettings own = OfAll();
  own.set_agent("alpha");
  own.set_version(9);
  own.clear_uplink_kbps();
  own.set_features(900);
  own.set_share("nearby");
  own.set_share_radius_m(20);
  SettableFlags flags;
  EXPECT_THAT(UseSettings(OfAll(), own, {}, flags),
              ElementsAre("features = 900  # version 9 of missions/lab/agents/alpha",
                          "share = nearby  # version 9 of missions/lab/agents/alpha",
                          "share-radius = 20  # version 9 of missions/lab/agents/alpha",
                          "uplink-kbps = 800  # version 4 of missions/lab"));
  EXPECT_EQ(flags.features, 900);
  EXPECT_EQ(flags.link.uplink_kbps, 800u);
  EXPECT_EQ(flags.share.mode, ShareMode::kNearby);
  EXPECT_EQ(ScopeOf(flags.share).radius_m, 20);
  EXPECT_EQ(flags.upload, "features=all");
}

TEST(SettingsFlagsTest, WhatWasGivenStaysAndIsSaid) {
  CLI::App app("robot");
  SettableFlags flags;
  app.add_option("--features", flags.features);
  app.add_option("--upload", flags.upload);
  app.parse("--features 700");
  EXPECT_THAT(GivenFlags(app), ElementsAre("--features"));
  EXPECT_THAT(UseSettings(OfAll(), {}, GivenFlags(app), flags),
              ElementsAre(HasSubstr("# features = 1500"), HasSubstr("uplink-kbps = 800")));
  EXPECT_EQ(flags.features, 700);
}

TEST(SettingsFlagsTest, FlagsThatNeedOthersAreRefused) {
  EXPECT_TRUE(CheckSettingsFlags({}, false).ok());
  EXPECT_THAT(std::string(CheckSettingsFlags({.key = "", .kept = "x"}, true).message()),
              HasSubstr("--settings-kept needs --settings-key"));
  EXPECT_THAT(std::string(CheckSettingsFlags({.key = "x", .kept = ""}, false).message()),
              HasSubstr("--settings-key needs --server"));
  const SettingsFlags unreadable = {.key = "/nowhere.pem", .kept = ""};
  EXPECT_TRUE(CheckSettingsFlags(unreadable, true).ok()) << "it ends no robot";
  EXPECT_THAT(std::string(CheckSettingsFiles(unreadable).message()), HasSubstr("/nowhere.pem"));
}

}  // namespace
}  // namespace corbslam::services
