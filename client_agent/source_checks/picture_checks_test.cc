#include "client_agent/source_checks/picture_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "client_agent/source_checks/source_checks.h"
#include "client_agent/source_checks/testing/damage_name.h"
#include "client_agent/source_checks/testing/layered_scene.h"

namespace corbslam::client_agent {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Sample StereoSample(const std::string& damage = "", double amount = 0) {
  return TakeSample(LayeredStereo(), damage, amount).value();
}

SourceFindings CheckStereo(const Sample& sample) {
  return CheckPictures(LayeredStereo().calibration, sample);
}

struct Light {
  const char* damage;
  double amount;
  const char* code;  // Finding for both cameras; "": none.
};
class PictureLightTest : public ::testing::TestWithParam<Light> {};

TEST_P(PictureLightTest, IsNamedWhereItIsTooLittleOrTooMuch) {
  const Light& light = GetParam();
  const SourceFindings findings = CheckStereo(StereoSample(light.damage, light.amount));
  if (*light.code == '\0') {
    EXPECT_THAT(CodesOf(findings), IsEmpty());
  } else {
    EXPECT_THAT(CodesOf(findings), ElementsAre(light.code, light.code));
  }
}

INSTANTIATE_TEST_SUITE_P(All, PictureLightTest,
                         ::testing::Values(Light{"", 0, ""}, Light{"noise", 20, ""},
                                           Light{"dark", 3, ""}, Light{"bright", 1.3, ""},
                                           Light{"dark", 16, "warning pictures-nearly-black"},
                                           Light{"dark", 64, "warning pictures-nearly-black"},
                                           Light{"dark", 1e6, "error pictures-constant"},
                                           Light{"bright", 8, "warning pictures-overexposed"}),
                         DamageName<Light>);

TEST(PictureChecksTest, SayWhichCameraAndHowDark) {
  Sample sample = StereoSample();
  for (SampleFrame& frame : sample) frame.images.right /= 20;
  const SourceFindings findings = CheckStereo(sample);
  ASSERT_THAT(CodesOf(findings), ElementsAre("warning pictures-nearly-black"));
  EXPECT_THAT(findings[0].text, HasSubstr("right pictures are nearly black in 12 of 12 frames"));
}

TEST(PictureChecksTest, LetAShutterOpenAndATunnelPass) {
  Sample sample = StereoSample();
  for (const size_t black : {0, 5, 6, 7}) {
    sample[black].images.grey.setTo(0);
    sample[black].images.right.setTo(0);
  }
  EXPECT_THAT(CheckStereo(sample), IsEmpty());
}

TEST(PictureChecksTest, NameTheFirstPictureOfAnotherSize) {
  Sample sample = StereoSample();
  sample[3].images.right = sample[3].images.right(cv::Rect(0, 0, 320, 180)).clone();
  const SourceFindings findings = CheckStereo(sample);
  ASSERT_THAT(CodesOf(findings), ElementsAre("error picture-size"));
  EXPECT_THAT(findings[0].text, HasSubstr("the right picture is 320x180, the calibration is that "
                                          "of 640x360"));
}

TEST(PictureChecksTest, FindTheSamePictureTwice) {
  const SourceFindings findings = CheckStereo(StereoSample("same"));
  ASSERT_THAT(CodesOf(findings), ElementsAre("error pair-same-picture"));
  EXPECT_THAT(findings[0].text, HasSubstr("in 12 of 12 frames"));
}

TEST(PictureChecksTest, WarnOfAPairWithTheSamePictureNowAndThen) {
  Sample sample = StereoSample();
  sample[4].images.right = sample[4].images.grey;
  EXPECT_THAT(CodesOf(CheckStereo(sample)), ElementsAre("warning pair-same-picture"));
}

TEST(PictureChecksTest, FindACameraThatIsStuck) {
  Sample sample = StereoSample();
  for (SampleFrame& frame : sample) frame.images.right = sample[0].images.right;
  const SourceFindings findings = CheckStereo(sample);
  ASSERT_THAT(CodesOf(findings), ElementsAre("error camera-stuck"));
  EXPECT_THAT(findings[0].text, HasSubstr("the right picture is the same to the byte"));
  for (SampleFrame& frame : sample) frame.images.grey = sample[0].images.grey;
  EXPECT_THAT(CodesOf(CheckStereo(sample)),
              ElementsAre("warning camera-stuck", "warning camera-stuck"));
}

TEST(PictureChecksTest, LetARobotStandStill) {
  const SampleSource source = LayeredStereo({.moving = 0});
  EXPECT_THAT(CheckPictures(source.calibration, TakeSample(source).value()), IsEmpty());
}

TEST(PictureChecksTest, WarnOfPicturesWithoutContrast) {
  const SampleSource source = LayeredStereo({.noise = 1, .contrast = 0});
  EXPECT_THAT(CodesOf(CheckPictures(source.calibration, TakeSample(source).value())),
              Contains("warning pictures-without-contrast"));
}

TEST(PictureChecksTest, TakeAnEmptySample) {
  EXPECT_THAT(CheckPictures(LayeredStereo().calibration, {}), IsEmpty());
  EXPECT_THAT(CheckPictures(LayeredRgbd().calibration, {}), IsEmpty());
}

TEST(SourceChecksTest, TellNothingMoreThanAnErrorOfThePictures) {
  EXPECT_THAT(CodesOf(JudgeSample(LayeredStereo().calibration, StereoSample("same")).findings),
              ElementsAre("error pair-same-picture"));
  EXPECT_THAT(CodesOf(JudgeSample(LayeredStereo().calibration, StereoSample("exchanged")).findings),
              ElementsAre("error pair-exchanged"));
}

}  // namespace
}  // namespace corbslam::client_agent
