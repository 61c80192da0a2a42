#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "services/programs/robot_flag_checks.h"

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

absl::StatusOr<UploadChoice> Parse(const std::string& upload) {
  RobotFlags flags;
  flags.upload = upload;
  return ParseUpload(flags);
}

TEST(UploadFlagTest, SaysWhatGoesUpOfAKeyframe) {
  EXPECT_EQ(Parse("features=all")->picture_width_px, 320);
  EXPECT_TRUE(Parse("features=all")->features.IsAll());
  EXPECT_EQ(Parse("features=mapped&picture=0")->picture_width_px, 0);
  EXPECT_FALSE(Parse("features=mapped&picture=0")->features.IsAll());
  EXPECT_EQ(Parse("picture=640")->picture_width_px, 640);
  EXPECT_TRUE(Parse("picture=640")->features.IsAll());
  EXPECT_EQ(Parse("picture=1280&features=500")->picture_width_px, 1280);
}

TEST(UploadFlagTest, WhatItIsNotIsRefusedByName) {
  for (const auto& [upload, text] : std::vector<std::pair<std::string, std::string>>{
           {"", "must be features=all"},
           {"all", "must be features=all"},
           {"features=all&", "must be features=all"},
           {"features=all,picture=0", "features=all,picture=0"},
           {"features=0", "features=0"},
           {"picture=63", "picture=63: must be 0 (none) or a width in pixels from 64 to 1280"},
           {"picture=-1", "picture=-1"},
           {"picture=1281", "picture=1281"},
           {"picture=320.5", "picture=320.5"},
           {"picture=", "picture=:"},
           {"picture=320&picture=0", "says picture twice"},
           {"features=all&features=9", "says features twice"},
           {"pictures=320", "must be features=all"}}) {
    const absl::Status status = Parse(upload).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << upload << ": " << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(text)) << upload;
  }
}

}  // namespace
}  // namespace corbslam::services
