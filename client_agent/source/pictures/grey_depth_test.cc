#include "client_agent/source/pictures/grey_depth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <vector>

#include "absl/strings/str_cat.h"

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Returns grey levels 0 to 255 multiplied, as a camera of more bits would give the same scene.
cv::Mat MakeRamp(int factor) {
  cv::Mat ramp(256, 256, CV_16UC1);
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 256; ++x) ramp.at<uint16_t>(y, x) = static_cast<uint16_t>(x * factor);
  }
  return ramp;
}

cv::Mat MakeRamp8() {
  cv::Mat ramp;
  MakeRamp(1).convertTo(ramp, CV_8U);
  return ramp;
}

struct Bits {
  int factor;
  int used_bits;
};
class GreyBitsTest : public ::testing::TestWithParam<Bits> {};

TEST_P(GreyBitsTest, ComeBackAsTheEightThatTheyWere) {
  const cv::Mat ramp = MakeRamp(GetParam().factor);
  const GreyDepth decision = DecideGreyDepth({ramp});
  EXPECT_EQ(decision.used_bits, GetParam().used_bits);
  EXPECT_EQ(decision.findings.empty(), GetParam().used_bits == 16);
  EXPECT_EQ(cv::norm(ScaleGreyTo8(ramp, decision.White()), MakeRamp8(), cv::NORM_INF), 0);
}

INSTANTIATE_TEST_SUITE_P(All, GreyBitsTest,
                         ::testing::Values(Bits{1, 8}, Bits{4, 10}, Bits{16, 12}, Bits{64, 14},
                                           Bits{256, 16}, Bits{257, 16}),
                         [](const auto& info) {
                           return absl::StrCat("times_", info.param.factor);
                         });

TEST(GreyDepthTest, DecidesForTheWholeSourceByItsBrightestPicture) {
  EXPECT_EQ(DecideGreyDepth({MakeRamp(2), MakeRamp(16), MakeRamp(4)}).used_bits, 12);
  EXPECT_EQ(DecideGreyDepth({MakeRamp(16), MakeRamp(257)}).used_bits, 16);
}

TEST(GreyDepthTest, IsNotMisledByAHotPixel) {
  cv::Mat grey(600, 600, CV_16UC1, cv::Scalar::all(900));
  grey.at<uint16_t>(17, 20) = 65535;
  const GreyDepth decision = DecideGreyDepth({grey});
  EXPECT_EQ(decision.used_bits, 10);
  EXPECT_EQ(ScaleGreyTo8(grey, 1 << 10).at<uint8_t>(17, 20), 255);
  EXPECT_EQ(ScaleGreyTo8(grey, 1 << 10).at<uint8_t>(0, 0), 225);
}

// A picture at night, with lamps in it that use the whole range.
cv::Mat MakeNight(int brightest_of_most) {
  cv::Mat night(200, 200, CV_16UC1);
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) {
      night.at<uint16_t>(y, x) = static_cast<uint16_t>(brightest_of_most * x / 199);
    }
  }
  night(cv::Rect(90, 90, 10, 10)) = cv::Scalar::all(65000);
  return night;
}

TEST(GreyDepthTest, ADarkPictureOfTheWholeRangeIsMadeBrightAndThatIsSaid) {
  const cv::Mat night = MakeNight(79 * 256);
  const GreyDepth decision = DecideGreyDepth({night});
  EXPECT_EQ(decision.used_bits, 16);
  EXPECT_EQ(decision.gain, 3);
  ASSERT_EQ(decision.findings.size(), 1u);
  EXPECT_EQ(decision.findings[0].code, "grey-dark");
  EXPECT_THAT(decision.findings[0].text, HasSubstr("3 times as bright"));
  const cv::Mat scaled = ScaleGreyTo8(night, decision.White());
  EXPECT_NEAR(scaled.at<uint8_t>(0, 199), 237, 1);
  EXPECT_EQ(scaled.at<uint8_t>(95, 95), 255);
  EXPECT_EQ(DecideGreyDepth({MakeNight(256)}).gain, 16)
      << "no more, noise would be all that is seen";
  EXPECT_EQ(DecideGreyDepth({MakeNight(120 * 256)}).gain, 1);
}

TEST(GreyDepthTest, AFewerBitsCamerasDarkPictureIsMadeBrightToo) {
  const cv::Mat night = MakeNight(79 * 256) / 64;
  const GreyDepth decision = DecideGreyDepth({night});
  EXPECT_EQ(decision.used_bits, 10);
  EXPECT_EQ(decision.gain, 3);
  EXPECT_EQ(decision.findings.size(), 2u);
}

TEST(GreyDepthTest, SaysWhatItAssumed) {
  const GreyDepth decision = DecideGreyDepth({MakeRamp(16)});
  ASSERT_EQ(decision.findings.size(), 1u);
  EXPECT_EQ(decision.findings[0].code, "grey-bits-assumed");
  EXPECT_EQ(decision.findings[0].level, FindingLevel::kWarning);
  EXPECT_THAT(decision.findings[0].text, HasSubstr("brightest value of the sample is 4080"));
  EXPECT_THAT(decision.findings[0].text, HasSubstr("divided by 16"));
}

TEST(GreyDepthTest, AssumesNothingOfPicturesOfEightBitsOrBlackOnes) {
  for (const cv::Mat& grey : {MakeRamp8(), cv::Mat(20, 20, CV_16UC1, cv::Scalar::all(0))}) {
    const GreyDepth decision = DecideGreyDepth({grey});
    EXPECT_EQ(decision.used_bits, 16);
    EXPECT_THAT(decision.findings, IsEmpty());
  }
  EXPECT_EQ(DecideGreyDepth({}).used_bits, 16);
  EXPECT_EQ(ScaleGreyTo8(MakeRamp8(), 1 << 10).at<uint8_t>(0, 200), 200);
}

}  // namespace
}  // namespace corbslam::client_agent
