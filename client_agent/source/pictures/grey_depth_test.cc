#include "client_agent/source/pictures/grey_depth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <vector>

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
  EXPECT_EQ(cv::norm(ScaleGreyTo8(ramp, decision.used_bits), MakeRamp8(), cv::NORM_INF), 0);
}

INSTANTIATE_TEST_SUITE_P(All, GreyBitsTest,
                         ::testing::Values(Bits{1, 8}, Bits{4, 10}, Bits{16, 12}, Bits{64, 14},
                                           Bits{256, 16}, Bits{257, 16}));

TEST(GreyDepthTest, DecidesForTheWholeSourceByItsBrightestPicture) {
  EXPECT_EQ(DecideGreyDepth({MakeRamp(2), MakeRamp(16), MakeRamp(4)}).used_bits, 12);
  EXPECT_EQ(DecideGreyDepth({MakeRamp(16), MakeRamp(257)}).used_bits, 16);
}

TEST(GreyDepthTest, IsNotMisledByAHotPixel) {
  cv::Mat grey(600, 600, CV_16UC1, cv::Scalar::all(900));
  grey.at<uint16_t>(17, 20) = 65535;
  const GreyDepth decision = DecideGreyDepth({grey});
  EXPECT_EQ(decision.used_bits, 10);
  EXPECT_EQ(ScaleGreyTo8(grey, 10).at<uint8_t>(17, 20), 255);
  EXPECT_EQ(ScaleGreyTo8(grey, 10).at<uint8_t>(0, 0), 225);
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
  EXPECT_EQ(ScaleGreyTo8(MakeRamp8(), 10).at<uint8_t>(0, 200), 200);
}

}  // namespace
}  // namespace corbslam::client_agent
