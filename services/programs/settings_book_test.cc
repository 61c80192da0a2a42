#include "services/programs/settings_book.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "services/security/robot_settings_signature.h"
#include "services/security/testing/token_keys.h"

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class SettingsBookTest : public ::testing::Test {
 protected:
  v1::SignedRobotSettings Sign(uint64_t version, const std::string& agent, uint32_t features,
                               const std::string& mission = "missions/lab") {
    v1::RobotSettings settings;
    settings.set_mission(mission);
    settings.set_agent(agent);
    settings.set_version(version);
    settings.set_features(features);
    return *SignRobotSettings(settings, keys_.private_pem);
  }
  SettingsBook::Taken Take(const v1::SignedRobotSettings& settings) {
    v1::RobotSettingsList list;
    *list.add_settings() = settings;
    return book_.Take(list);
  }
  void ExpectRefused(const v1::SignedRobotSettings& settings, const std::string& says) {
    const SettingsBook::Taken taken = Take(settings);
    EXPECT_FALSE(taken.changed);
    ASSERT_THAT(taken.refused, SizeIs(1));
    EXPECT_THAT(std::string(taken.refused[0].message()), HasSubstr(says));
  }

  const test_data::TokenKeys keys_ = test_data::MakeTokenKeys();
  SettingsBook book_{*ReadEd25519PublicKeys("settings key", keys_.public_pem), "lab", "alpha"};
};

TEST_F(SettingsBookTest, TakesTheNewestOfAllAndOfTheRobot) {
  v1::RobotSettingsList list;
  *list.add_settings() = Sign(5, "", 1000);
  *list.add_settings() = Sign(3, "alpha", 1200);
  EXPECT_TRUE(book_.Take(list).changed);
  EXPECT_EQ(book_.of_all().features(), 1000u);
  EXPECT_EQ(book_.own().features(), 1200u);
  // A session that begins again tells the same.
  const SettingsBook::Taken again = book_.Take(list);
  EXPECT_FALSE(again.changed);
  EXPECT_THAT(again.refused, IsEmpty());
  EXPECT_TRUE(Take(Sign(4, "alpha", 1300)).changed);
  EXPECT_EQ(book_.own().features(), 1300u);
  EXPECT_THAT(book_.list().settings(), SizeIs(2));
}

TEST_F(SettingsBookTest, RefusesOlderVersionsByName) {
  ASSERT_TRUE(Take(Sign(5, "alpha", 1000)).changed);
  ExpectRefused(
      Sign(4, "alpha", 2000),
      "version 4 of missions/lab/agents/alpha are refused: this robot has taken version 5");
  ExpectRefused(Sign(5, "alpha", 2000), "which says something else");
  EXPECT_EQ(book_.own().features(), 1000u);
}

TEST_F(SettingsBookTest, RefusesWhatIsOfOthersOrBadlySigned) {
  ExpectRefused(Sign(1, "alpha", 100, "missions/other"), "this robot is missions/lab/agents/alpha");
  ExpectRefused(Sign(1, "bravo", 100), "this robot is missions/lab/agents/alpha");
  v1::SignedRobotSettings forged = Sign(9, "alpha", 100);
  forged.mutable_signature()->front() ^= 1;
  ExpectRefused(forged, "call themselves version 9 of missions/lab/agents/alpha");
  forged.set_settings("\xff\xff");
  ExpectRefused(forged, "nothing that can be read");
  EXPECT_EQ(book_.own().version(), 0u);
  EXPECT_THAT(book_.list().settings(), IsEmpty());
}

// Returns what a robot says that can't run with more features.
SettingsBook::Fits AtMost(uint32_t features) {
  return [features](const v1::RobotSettings& of_all, const v1::RobotSettings& own) {
    const uint32_t wanted = own.has_features() ? own.features() : of_all.features();
    if (wanted <= features) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrCat(wanted, " are too many"));
  };
}

TEST_F(SettingsBookTest, WhatDoesNotFitLeavesAllAsItWasFromProcessToProcess) {
  v1::RobotSettingsList good;
  *good.add_settings() = Sign(5, "alpha", 1000);
  ASSERT_TRUE(book_.Take(good, AtMost(1500)).changed);
  v1::RobotSettingsList bad;
  *bad.add_settings() = Sign(6, "alpha", 9000);
  for (int session = 0; session < 3; ++session) {
    const SettingsBook::Taken taken = book_.Take(bad, AtMost(1500));
    EXPECT_FALSE(taken.changed);
    EXPECT_EQ(taken.learned, session == 0);
    ASSERT_THAT(taken.refused, SizeIs(1));
    EXPECT_THAT(std::string(taken.refused[0].message()),
                HasSubstr("version 6 of missions/lab/agents/alpha don't fit this robot, which goes "
                          "on as it was: 9000 are too many"));
  }
  EXPECT_EQ(book_.own().features(), 1000u);
  // The next process of the robot has what it kept.
  SettingsBook next(*ReadEd25519PublicKeys("settings key", keys_.public_pem), "lab", "alpha");
  const SettingsBook::Taken again = next.Take(book_.list(), AtMost(1500));
  EXPECT_TRUE(again.changed);
  EXPECT_THAT(again.refused, SizeIs(1)) << "it says so again";
  EXPECT_EQ(next.own().features(), 1000u);
  // A store that tells older ones, which nobody refused then, is not followed.
  v1::RobotSettingsList older;
  *older.add_settings() = Sign(4, "alpha", 500);
  EXPECT_FALSE(next.Take(older, AtMost(1500)).changed);
  // With other flags it can follow.
  SettingsBook able(*ReadEd25519PublicKeys("settings key", keys_.public_pem), "lab", "alpha");
  EXPECT_TRUE(able.Take(book_.list(), AtMost(10'000)).changed);
  EXPECT_EQ(able.own().features(), 9000u);
  EXPECT_THAT(able.list().settings(), SizeIs(1));
}

TEST_F(SettingsBookTest, OfTwoThatDontFitTogetherTheOneThatFitsIsTaken) {
  v1::RobotSettingsList list;
  *list.add_settings() = Sign(5, "", 9000);
  *list.add_settings() = Sign(3, "alpha", 1200);
  EXPECT_THAT(book_.Take(list, AtMost(1500)).refused, IsEmpty()) << "its own go before";
  list.Clear();
  *list.add_settings() = Sign(6, "", 1300);
  *list.add_settings() = Sign(4, "alpha", 9000);
  EXPECT_THAT(book_.Take(list, AtMost(1500)).refused, SizeIs(1));
  EXPECT_EQ(book_.of_all().version(), 6u);
  EXPECT_EQ(book_.own().version(), 3u);
}

// An older map store keeps what an older tool signed.
TEST_F(SettingsBookTest, WhatNoRobotCanRunWithIsRefused) {
  v1::RobotSettings settings;
  settings.set_mission("missions/lab");
  settings.set_agent("alpha");
  settings.set_version(9);
  settings.set_features(1);
  v1::SignedRobotSettings made;
  made.set_settings(settings.SerializeAsString());
  made.set_signature(*SignBytes(absl::StrCat("corbslam-robot-settings-1\n", made.settings()),
                                *ReadEd25519PrivateKey(keys_.private_pem)));
  ExpectRefused(made, "features is 1, must be 50 to 20000");
}

}  // namespace
}  // namespace corbslam::services
