#include "client_agent/source_checks/depth_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "client_agent/source_checks/testing/damage.h"
#include "client_agent/source_checks/testing/damage_name.h"
#include "client_agent/source_checks/testing/layered_scene.h"

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

SourceFindings Check(const SampleSource& source, const std::string& damage = "",
                     double amount = 0) {
  return CheckDepth(std::get<RgbdCalibration>(source.calibration),
                    TakeSample(source, damage, amount).value());
}

struct DepthCase {
  const char* damage;
  double amount;
  const char* code;  // "": none.
  const char* text;
};
// The recorded cases have a depth that is late by one frame: the painted camera doesn't turn, so
// that what is measured as its motion, the background's, is half that of the outlines.
class DepthDamageTest : public ::testing::TestWithParam<DepthCase> {};

TEST_P(DepthDamageTest, IsNamed) {
  const DepthCase& damage = GetParam();
  const SourceFindings findings = Check(LayeredRgbd(), damage.damage, damage.amount);
  if (*damage.code == '\0') {
    EXPECT_THAT(CodesOf(findings), IsEmpty());
    return;
  }
  ASSERT_THAT(CodesOf(findings), ElementsAre(damage.code));
  EXPECT_THAT(findings[0].text, HasSubstr(damage.text));
}

INSTANTIATE_TEST_SUITE_P(
    All, DepthDamageTest,
    ::testing::Values(
        DepthCase{"", 0, "", ""}, DepthCase{"noise", 20, "", ""}, DepthCase{"dark", 8, "", ""},
        DepthCase{"depth_shift", 3, "", ""},
        DepthCase{"depth_empty", 0, "error depth-empty", "in any of 20 frames"},
        DepthCase{"depth_constant", 2500, "error depth-constant", "one value, 0.500 m"},
        DepthCase{"depth_saturated", 0, "warning depth-saturated", "are 65535"},
        DepthCase{"depth_scale", 0.1, "warning depth-units-implausible", "5000 depth units"},
        DepthCase{"depth_late", 2, "warning depth-late", "behind their pictures"},
        DepthCase{"depth_shift", 12, "warning depth-not-registered", "px beside their pictures"},
        DepthCase{"depth_shift", -20, "warning depth-not-registered", "px beside"}),
    DamageName<DepthCase>);

// Depth of a second camera lies elsewhere beside what is near than beside what is far.
TEST(DepthChecksTest, NameNoOffsetWhereThereIsNotOne) {
  const SampleSource source = LayeredRgbd();
  const ReadFrame right = Damage(source.read, "depth_shift", 14);
  const ReadFrame left = Damage(source.read, "depth_shift", -20);
  SampleSource parts = source;
  parts.read = [=](size_t frame) { return frame < source.frames / 2 ? right(frame) : left(frame); };
  const SourceFindings findings = Check(parts);
  ASSERT_THAT(CodesOf(findings), ElementsAre("warning depth-not-registered"));
  EXPECT_THAT(findings[0].text, HasSubstr("no one offset brings them there"));
  EXPECT_THAT(findings[0].text, Not(HasSubstr("px")));
}

TEST(DepthChecksTest, WarnOfUnitsThatAreTooCoarse) {
  SampleSource source = LayeredRgbd();
  std::get<RgbdCalibration>(source.calibration).depth_units_per_m = 500;
  const SourceFindings findings = Check(source);
  ASSERT_THAT(CodesOf(findings), ElementsAre("warning depth-units-implausible"));
  EXPECT_THAT(findings[0].text, HasSubstr("with 500 depth units a metre"));
}

TEST(DepthChecksTest, DoubtDepthOfAnotherScene) {
  const SampleSource source = LayeredRgbd();
  const SampleSource other = LayeredRgbd({.seed = 9, .farthest_px = 20});
  SampleSource mixed = source;
  mixed.read = [source, other](size_t frame) -> absl::StatusOr<SensorImages> {
    SensorImages images = source.read(frame).value();
    images.depth = other.read(frame + 7).value().depth;
    return images;
  };
  mixed.frames -= 7;
  EXPECT_THAT(CodesOf(Check(mixed)), Not(IsEmpty()));
}

TEST(DepthChecksTest, TakeDepthInMetres) {
  const SampleSource source = LayeredRgbd();
  SampleSource metres = source;
  metres.read = [source](size_t frame) -> absl::StatusOr<SensorImages> {
    SensorImages images = source.read(frame).value();
    cv::Mat depth;
    images.depth.convertTo(depth, CV_32F, 1 / 5000.0);
    images.depth = depth;
    return images;
  };
  EXPECT_THAT(CodesOf(Check(metres)), IsEmpty());
  EXPECT_THAT(CodesOf(Check(metres, "depth_late", 2)), ElementsAre("warning depth-late"));
}

TEST(DepthChecksTest, NameADepthImageOfAnotherSize) {
  const SampleSource source = LayeredRgbd();
  Sample sample = TakeSample(source).value();
  sample[7].images.depth = cv::Mat(180, 320, CV_16UC1, cv::Scalar::all(5000));
  const SourceFindings findings = CheckDepth(std::get<RgbdCalibration>(source.calibration), sample);
  ASSERT_THAT(CodesOf(findings), ElementsAre("error depth-size"));
  EXPECT_THAT(findings[0].text, HasSubstr("the depth image is 320x180"));
}

TEST(DepthChecksTest, WarnOfHardlyAnyDepth) {
  const SampleSource source = LayeredRgbd();
  Sample sample = TakeSample(source).value();
  for (SampleFrame& frame : sample) frame.images.depth.rowRange(12, 360).setTo(0);
  EXPECT_THAT(CodesOf(CheckDepth(std::get<RgbdCalibration>(source.calibration), sample)),
              ElementsAre("warning depth-sparse"));
}

TEST(DepthChecksTest, JudgeNoTimeOfDepthWhileTheRobotStandsStill) {
  EXPECT_THAT(CodesOf(Check(LayeredRgbd({.moving = 0, .farthest_px = 20}))), IsEmpty());
  EXPECT_THAT(CodesOf(Check(LayeredRgbd({.moving = 0, .farthest_px = 20}), "depth_late", 2)),
              IsEmpty());
  EXPECT_THAT(CheckDepth(RgbdCalibration(), {}), IsEmpty());
}

TEST(DepthChecksTest, LetABareWallBe) {
  EXPECT_THAT(CodesOf(Check(LayeredRgbd({.noise = 2, .contrast = 0, .farthest_px = 20}))),
              IsEmpty());
}

}  // namespace
}  // namespace corbslam::client_agent
