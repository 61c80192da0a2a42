#include "map_store/ingest/picture_validation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "map_store/testing/grey_jpeg.h"

namespace corbslam::map_store {
namespace {

using ::testing::HasSubstr;
using testing::MakeGreyJpeg;

constexpr KeyframeId kKeyframe{{7}, 3};

TEST(PictureValidationTest, AWholeGreyJpegIsTaken) {
  EXPECT_TRUE(ValidatePicture({kKeyframe, MakeGreyJpeg(320, 96, 500), 3.878}).ok());
  EXPECT_TRUE(ValidatePicture({kKeyframe, MakeGreyJpeg(4096, 1, 0), 1}).ok());
  EXPECT_TRUE(ValidatePicture({kKeyframe, MakeGreyJpeg(1, 4096, 0), 64}).ok());
}

TEST(PictureValidationTest, WhatIsNoGreyJpegIsRefusedWithTheReason) {
  const std::string good = MakeGreyJpeg(320, 96, 50);
  std::string arithmetic = good;
  arithmetic[9] = static_cast<char>(0xc9);
  std::string two_frames = good.substr(0, 21) + good.substr(8);
  std::string long_segment = good;
  long_segment[4] = static_cast<char>(0x7f);
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "does not begin as one"},
      {"<html>", "does not begin as one"},
      {good.substr(0, good.size() - 2), "cut short"},
      {good.substr(0, 30), "cut short"},
      {std::string("\xff\xd8\xff\xd9", 4), "no scan"},
      {std::string("\xff\xd8\xff\xda\x00\x02\xff\xd9", 8), "no frame's header"},
      {long_segment, "segment at byte 2 is cut short"},
      {arithmetic, "browsers don't decode"},
      {two_frames, "two frames"},
      {MakeGreyJpeg(320, 96, 50, 12), "12 bits a pixel"},
      {MakeGreyJpeg(320, 96, 50, 8, 3), "3 colours"},
      {MakeGreyJpeg(0, 96, 50), "0x96 pixels"},
      {MakeGreyJpeg(65535, 65535, 50), "65535x65535 pixels, must be 1 to 4096"},
      {"\x89PNG\r\n\x1a\n", "does not begin as one"},
  };
  for (const auto& [jpeg, text] : cases) {
    const absl::Status status = ValidatePicture({kKeyframe, jpeg, 2});
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << text << ": " << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(text));
    EXPECT_THAT(std::string(status.message()), HasSubstr(ToString(kKeyframe)));
  }
}

// Nothing that is cut or turned over anywhere is read beyond its end.
TEST(PictureValidationTest, DamageAnywhereIsNoTrouble) {
  const std::string good = MakeGreyJpeg(320, 96, 20);
  for (size_t i = 0; i < good.size(); ++i) {
    ValidateGreyJpeg(good.substr(0, i)).IgnoreError();
    for (const int bits : {0x01, 0x80, 0xff}) {
      std::string turned = good;
      turned[i] = static_cast<char>(turned[i] ^ bits);
      ValidateGreyJpeg(turned).IgnoreError();
    }
  }
}

TEST(PictureValidationTest, ScaleSizeAndKeyframeHaveTheirLimits) {
  const std::string good = MakeGreyJpeg(320, 96, 50);
  for (const double scale : {0.0, 0.99, 64.5, -2.0, HUGE_VAL, std::nan("")}) {
    EXPECT_THAT(std::string(ValidatePicture({kKeyframe, good, scale}).message()),
                HasSubstr("must be from 1 to 64"))
        << scale;
  }
  const std::string large = MakeGreyJpeg(320, 96, kMaxPictureBytes);
  EXPECT_THAT(std::string(ValidatePicture({kKeyframe, large, 2}).message()),
              HasSubstr("bytes; the limit is 65536"));
  EXPECT_TRUE(absl::IsInvalidArgument(ValidatePicture({KeyframeId(), good, 2})));
}

}  // namespace
}  // namespace corbslam::map_store
