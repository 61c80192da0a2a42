#include "services/programs/kept_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "absl/strings/str_cat.h"

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

v1::RobotSettingsList TwoSettings() {
  v1::RobotSettingsList list;
  for (const char* bytes : {"of all robots", "of this one"}) {
    v1::SignedRobotSettings& entry = *list.add_settings();
    entry.set_settings(bytes);
    entry.set_signature(std::string(64, 's'));
  }
  return list;
}

class KeptSettingsTest : public ::testing::Test {
 protected:
  KeptSettingsTest() {
    std::filesystem::remove(path_);
    std::filesystem::remove(path_ + ".damaged");
  }
  std::string Bytes() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void SetBytes(const std::string& bytes) const {
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << bytes;
  }

  const std::string path_ =
      absl::StrCat(::testing::TempDir(), "/corbslam_kept_",
                   ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(KeptSettingsTest, WhatWasKeptIsReadAgain) {
  ASSERT_TRUE(ReadKeptSettings(path_).ok());
  EXPECT_THAT(ReadKeptSettings(path_)->settings(), IsEmpty());
  ASSERT_TRUE(WriteKeptSettings(TwoSettings(), path_).ok());
  EXPECT_EQ(ReadKeptSettings(path_)->SerializeAsString(), TwoSettings().SerializeAsString());
  EXPECT_THAT(std::string(WriteKeptSettings(TwoSettings(), "/nowhere/kept").message()),
              HasSubstr("/nowhere/kept"));
}

TEST_F(KeptSettingsTest, OlderAndNewerRobotsReadTheSameFile) {
  SetBytes(TwoSettings().SerializeAsString());
  EXPECT_EQ(ReadKeptSettings(path_)->settings_size(), 2) << "an older one has written no checksum";
  ASSERT_TRUE(WriteKeptSettings(TwoSettings(), path_).ok());
  v1::RobotSettingsList as_older;
  ASSERT_TRUE(as_older.ParseFromString(Bytes()));
  EXPECT_EQ(as_older.settings_size(), 2);
}

// After a loss of power or on a bad disk: never as if nothing had been kept.
TEST_F(KeptSettingsTest, AFileThatIsEmptyCutShortOrChangedIsDamaged) {
  ASSERT_TRUE(WriteKeptSettings(TwoSettings(), path_).ok());
  const std::string whole = Bytes();
  for (size_t size = 0; size < whole.size(); ++size) {
    SetBytes(whole.substr(0, size));
    const absl::Status status = ReadKeptSettings(path_).status();
    ASSERT_TRUE(absl::IsDataLoss(status)) << size << " of " << whole.size() << ": " << status;
    ASSERT_THAT(std::string(status.message()), HasSubstr(path_));
  }
  for (size_t i = 0; i < whole.size(); ++i) {
    std::string changed = whole;
    changed[i] ^= 4;
    SetBytes(changed);
    ASSERT_FALSE(ReadKeptSettings(path_).ok()) << i;
  }
  SetBytes("");
  EXPECT_THAT(std::string(ReadKeptSettings(path_).status().message()), HasSubstr("is empty"));
}

TEST_F(KeptSettingsTest, AFolderIsSaidAndEndsNothing) {
  EXPECT_TRUE(absl::IsUnavailable(ReadKeptSettings(::testing::TempDir()).status()));
  EXPECT_FALSE(WriteKeptSettings(TwoSettings(), ::testing::TempDir()).ok());
}

TEST_F(KeptSettingsTest, WhatIsNoneOfItsFilesIsNotOverwritten) {
  SetBytes("somebody's notes");
  EXPECT_TRUE(absl::IsDataLoss(ReadKeptSettings(path_).status()));
  ASSERT_TRUE(WriteKeptSettings(TwoSettings(), path_).ok());
  EXPECT_EQ(ReadKeptSettings(path_)->settings_size(), 2);
  EXPECT_EQ(std::filesystem::file_size(path_ + ".damaged"), 16u);
}

}  // namespace
}  // namespace corbslam::services
