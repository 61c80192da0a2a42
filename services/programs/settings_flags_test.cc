#include "services/programs/settings_flags.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace corbslam::services {
namespace {

using ::testing::AllOf;
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
  EXPECT_EQ(flags.uplink_kbps, 800u);
  EXPECT_EQ(flags.share, ShareMode::kNearby);
  EXPECT_EQ(ScopeOf(flags, /*is_bounded=*/false).radius_m, 20);
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

// Returns what is wrong with the argument; empty if nothing.
std::string Parse(const std::string& flag, const std::string& value, SettableFlags& flags) {
  CLI::App app;
  AddSettings(app, RowsOf(flags));
  try {
    app.parse(std::vector<std::string>{flag + "=" + value});
  } catch (const CLI::Error& error) {
    return error.what();
  }
  return "";
}

TEST(SettableFlagsTest, EachSettingFromAfarHasItsFlag) {
  SettableFlags flags;
  for (const RobotSetting& row : RobotSettingTable()) {
    const auto is_its = [&](const Setting& one) {
      return one.flag == std::string("--") + row.flag;
    };
    const auto rows = RowsOf(flags);
    EXPECT_EQ(std::count_if(rows.begin(), rows.end(), is_its), row.is_file ? 0 : 1) << row.flag;
  }
}

TEST(SettableFlagsTest, NumbersAreWithinTheBoundsOfTheirRows) {
  SettableFlags flags;
  for (const char* value : {"0", "8", "10000000"}) {
    EXPECT_EQ(Parse("--uplink-kbps", value, flags), "") << value;
    EXPECT_EQ(flags.uplink_kbps, std::stoull(value));
  }
  for (const char* value :
       {"7", "1", "10000001", "-1", "256k", "1e3", "12.5", "nan", "18446744073709551616"}) {
    EXPECT_THAT(Parse("--uplink-kbps", value, flags),
                AllOf(HasSubstr("--uplink-kbps"), HasSubstr(value), HasSubstr("8 to 10000000")));
  }
  for (const char* value : {"0", "0.9", "-5", "1000001", "nan", "inf", "near"}) {
    EXPECT_THAT(Parse("--share-radius", value, flags),
                AllOf(HasSubstr("--share-radius"), HasSubstr(value), HasSubstr("1 to 1e+06")));
  }
  for (const char* value : {"49", "20001", "1.5"}) {
    EXPECT_THAT(Parse("--features", value, flags),
                AllOf(HasSubstr(value), HasSubstr("50 to 20000")));
  }
  EXPECT_EQ(Parse("--features", "0", flags), "");
  EXPECT_THAT(Parse("--max-rate", "0.05", flags), HasSubstr("0.1 to 1000, or 0 for all"));
}

TEST(SettableFlagsTest, ShareIsWhatTheStoreIsAskedFor) {
  SettableFlags flags;
  EXPECT_EQ(ScopeOf(flags, /*is_bounded=*/false), ShareScope());
  EXPECT_TRUE(CheckShare(flags, /*is_bounded=*/false, /*has_server=*/false).ok());
  for (const auto& [name, mode] : kShareModes) {
    EXPECT_EQ(Parse("--share", name, flags), "");
    EXPECT_EQ(ScopeOf(flags, /*is_bounded=*/false).mode, mode);
    EXPECT_EQ(ScopeOf(flags, /*is_bounded=*/false).radius_m, 50);
    EXPECT_TRUE(CheckShare(flags, /*is_bounded=*/false, /*has_server=*/true).ok());
  }
  EXPECT_THAT(Parse("--share", "half", flags), AllOf(HasSubstr("--share"), HasSubstr("half")));
  EXPECT_EQ(Parse("--share", "none", flags), "");
  EXPECT_THAT(std::string(CheckShare(flags, false, /*has_server=*/false).message()),
              HasSubstr("--share needs --server"));
  EXPECT_EQ(Parse("--share-radius", "7", flags), "");
  EXPECT_THAT(std::string(CheckShare(flags, false, /*has_server=*/true).message()),
              AllOf(HasSubstr("--share-radius is 7"), HasSubstr("--share nearby")));
}

}  // namespace
}  // namespace corbslam::services
