#include "client_agent/source_checks/stereo_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "client_agent/source_checks/testing/damage_name.h"
#include "client_agent/source_checks/testing/layered_scene.h"

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

SourceFindings Check(const SampleSource& source, const std::string& damage = "",
                     double amount = 0) {
  return JudgeStereoPair(std::get<StereoCalibration>(source.calibration),
                         TakeSample(source, damage, amount).value())
      .findings;
}

StereoCalibration& CalibrationOf(SampleSource& source) {
  return std::get<StereoCalibration>(source.calibration);
}

struct PairCase {
  const char* damage;
  double amount;
  const char* code;  // "": none.
  const char* text;
};
class PairDamageTest : public ::testing::TestWithParam<PairCase> {};

TEST_P(PairDamageTest, IsNamed) {
  const PairCase& damage = GetParam();
  const SourceFindings findings = Check(LayeredStereo(), damage.damage, damage.amount);
  if (*damage.code == '\0') {
    EXPECT_THAT(CodesOf(findings), IsEmpty());
    return;
  }
  ASSERT_THAT(CodesOf(findings), ElementsAre(damage.code));
  EXPECT_THAT(findings[0].text, HasSubstr(damage.text));
}

INSTANTIATE_TEST_SUITE_P(
    All, PairDamageTest,
    ::testing::Values(
        PairCase{"", 0, "", ""}, PairCase{"noise", 12, "", ""}, PairCase{"dark", 6, "", ""},
        PairCase{"rows", 0.25, "", ""},
        PairCase{"exchanged", 0, "error pair-exchanged", "left and right are exchanged: 100 %"},
        PairCase{"same", 0, "warning pair-without-parallax", "at the same pixel"},
        PairCase{"rows", 2, "warning pair-rows-apart", "px lower in its middle"},
        PairCase{"rows", -2, "warning pair-rows-apart", "px higher in its middle"},
        PairCase{"rows", 8, "error pair-rows-apart", "rows of left and right pictures are"},
        PairCase{"roll", 1, "warning pair-rows-apart", "turned by"},
        PairCase{"late", 1, "warning pair-late", "the right camera is a frame or more behind"},
        PairCase{"mirrored", 0, "error pair-unrelated", "hardly have anything in common"}),
    DamageName<PairCase>);

TEST(StereoChecksTest, TellALateLeftCamera) {
  const SampleSource source = LayeredStereo();
  SampleSource late = source;
  late.read = [source](size_t frame) -> absl::StatusOr<SensorImages> {
    SensorImages images = source.read(frame).value();
    images.grey = source.read(frame - std::min<size_t>(frame, 1)).value().grey;
    return images;
  };
  const SourceFindings findings = Check(late);
  ASSERT_THAT(CodesOf(findings), ElementsAre("warning pair-late"));
  EXPECT_THAT(findings[0].text, HasSubstr("the left camera is a frame or more behind"));
}

TEST(StereoChecksTest, TellPicturesOfAnotherScene) {
  const SampleSource source = LayeredStereo();
  const SampleSource other = LayeredStereo({.seed = 9});
  SampleSource mixed = source;
  mixed.read = [source, other](size_t frame) -> absl::StatusOr<SensorImages> {
    SensorImages images = source.read(frame).value();
    images.right = other.read(frame).value().right;
    return images;
  };
  EXPECT_THAT(CodesOf(Check(mixed)), ElementsAre("error pair-unrelated"));
}

struct Scene {
  const char* name;
  LayeredSceneOptions options;
};
class ValidPairTest : public ::testing::TestWithParam<Scene> {};

TEST_P(ValidPairTest, IsNotDoubted) {
  EXPECT_THAT(CodesOf(Check(LayeredStereo(GetParam().options))), IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(
    All, ValidPairTest,
    ::testing::Values(Scene{"standing still", {.moving = 0}}, Scene{"fast", {.moving = 3}},
                      Scene{"another", {.seed = 4}}, Scene{"low contrast", {.contrast = 0.2}},
                      Scene{"far horizon", {.farthest_px = 1, .nearest_px = 4}},
                      Scene{"bare wall", {.noise = 2, .contrast = 0}},
                      Scene{"bare wall in bad light", {.noise = 12, .contrast = 0}},
                      Scene{"near", {.farthest_px = 30, .nearest_px = 90}}),
    [](const auto& scene) {
      std::string name = scene.param.name;
      std::replace(name.begin(), name.end(), ' ', '_');
      return name;
    });

TEST(StereoChecksTest, WarnOfABaselineInMillimetres) {
  SampleSource source = LayeredStereo();
  CalibrationOf(source).camera.baseline_m = 100;
  const SourceFindings findings = Check(source);
  ASSERT_THAT(CodesOf(findings), ElementsAre("warning baseline-implausible"));
  EXPECT_THAT(findings[0].text, HasSubstr("the baseline is 100 m, outside 0.01 to 5 m"));
  EXPECT_THAT(findings[0].text, HasSubstr("m away (median)"));
  CalibrationOf(source).camera.baseline_m = 0.0001;
  EXPECT_THAT(CodesOf(Check(source)), ElementsAre("warning baseline-implausible"));
}

TEST(StereoChecksTest, HonourAnotherPrincipalColumnOfTheRightCamera) {
  SampleSource source = LayeredStereo();
  CalibrationOf(source).right_cx_offset_px = 12;
  EXPECT_THAT(CodesOf(Check(source, "columns", 12)), IsEmpty());
}

TEST(StereoChecksTest, PassOverPicturesOfAnotherSizeAndAnEmptySample) {
  SampleSource source = LayeredStereo();
  CalibrationOf(source).camera.width_px = 320;
  EXPECT_THAT(CodesOf(Check(source, "exchanged")), IsEmpty());
  EXPECT_THAT(JudgeStereoPair(CalibrationOf(source), {}).findings, IsEmpty());
}

TEST(StereoChecksTest, TellAnImpossibleCalibration) {
  StereoCalibration calibration;
  calibration.raw = RawStereo();
  EXPECT_THAT(CodesOf(JudgeStereoPair(calibration, {}).findings),
              ElementsAre("error calibration-impossible"));
}

}  // namespace
}  // namespace corbslam::client_agent
