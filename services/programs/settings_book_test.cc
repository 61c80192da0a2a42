#include "services/programs/settings_book.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

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
  ExpectRefused(Sign(1, "alpha", 1, "missions/other"), "this robot is missions/lab/agents/alpha");
  ExpectRefused(Sign(1, "bravo", 1), "this robot is missions/lab/agents/alpha");
  v1::SignedRobotSettings forged = Sign(9, "alpha", 1);
  forged.mutable_signature()->front() ^= 1;
  ExpectRefused(forged, "call themselves version 9 of missions/lab/agents/alpha");
  forged.set_settings("\xff\xff");
  ExpectRefused(forged, "nothing that can be read");
  EXPECT_EQ(book_.own().version(), 0u);
  EXPECT_THAT(book_.list().settings(), IsEmpty());
}

TEST_F(SettingsBookTest, WhatWasKeptIsReadAgain) {
  const std::string path = ::testing::TempDir() + "/corbslam_settings_kept";
  std::filesystem::remove(path);
  ASSERT_TRUE(ReadKept(path).ok());
  EXPECT_THAT(ReadKept(path)->settings(), IsEmpty());
  ASSERT_TRUE(Take(Sign(5, "alpha", 1000)).changed);
  ASSERT_TRUE(WriteKept(book_.list(), path).ok());
  EXPECT_EQ(ReadKept(path)->SerializeAsString(), book_.list().SerializeAsString());
  std::ofstream(path) << "no settings";
  EXPECT_THAT(std::string(ReadKept(path).status().message()), HasSubstr(path));
  EXPECT_THAT(std::string(WriteKept(book_.list(), "/nowhere/kept").message()),
              HasSubstr("/nowhere/kept"));
}

}  // namespace
}  // namespace corbslam::services
