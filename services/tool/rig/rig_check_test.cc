#include "services/tool/rig/rig_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <variant>

#include "client_agent/source_checks/testing/layered_scene.h"
#include "client_agent/source_checks/testing/sample_source.h"

namespace corbslam::services {
namespace {

using client_agent::FrameReader;
using client_agent::LayeredRgbd;
using client_agent::LayeredStereo;
using client_agent::SampleSource;
using client_agent::SourceDescription;
using client_agent::SourceSpec;
using ::testing::HasSubstr;
using ::testing::Not;

// A sample source, with something wrong with it, as a recording.
class SceneReader : public FrameReader {
 public:
  SceneReader(SampleSource source, const std::string& damage, double amount)
      : source_(std::move(source)), read_(client_agent::Damage(source_.read, damage, amount)) {
    client_agent::DescribeCamera(source_.calibration, description_);
    description_.frames = source_.frames;
  }
  const SensorCalibration& calibration() const override { return source_.calibration; }
  const SourceDescription& description() const override { return description_; }
  size_t frame_count() const override { return source_.frames; }
  int64_t timestamp_ns(size_t frame) const override {
    return static_cast<int64_t>(frame) * 50000000;
  }
  int drive(size_t) const override { return 0; }
  absl::StatusOr<SensorImages> Read(size_t frame) const override { return read_(frame); }

 private:
  const SampleSource source_;
  const client_agent::ReadFrame read_;
  SourceDescription description_;
};

RigCheck Check(SampleSource source, const std::string& damage = "", double amount = 0) {
  const SceneReader reader(std::move(source), damage, amount);
  auto check = CheckRig(reader, SourceSpec());
  EXPECT_TRUE(check.ok()) << check.status();
  return *std::move(check);
}

TEST(RigCheckTest, SaysThatARightRigIsRight) {
  const RigCheck check = Check(LayeredStereo());
  EXPECT_TRUE(check.IsUsable());
  const std::string text = FormatRigCheck(check);
  EXPECT_THAT(text, HasSubstr("RIGHT: the pictures agree with the rig."));
  EXPECT_THAT(text, HasSubstr("rows: 0."));
  EXPECT_THAT(text, HasSubstr("exposure: medians"));
  EXPECT_EQ(check.picture.cols, 2 * 640);
  EXPECT_EQ(check.picture.rows, 360);
}

TEST(RigCheckTest, SaysWhatRowsCannotShow) {
  EXPECT_THAT(FormatRigCheck(Check(LayeredStereo())),
              HasSubstr("can't show a wrong baseline, nor the same wrong focal length"));
}

TEST(RigCheckTest, ABareWallIsWrong) {
  const RigCheck check = Check(LayeredStereo({.contrast = 0}));
  EXPECT_FALSE(check.IsUsable());
  EXPECT_THAT(FormatRigCheck(check), HasSubstr("pair-not-judged: no pair could be judged"));
  EXPECT_THAT(FormatRigCheck(check), HasSubstr("WRONG: "));
}

// The layered scene's own cameras are pinholes: both are told to distort, one of them more.
TEST(RigCheckTest, AWrongLensIsNotRight) {
  SampleSource source = LayeredStereo();
  auto& stereo = std::get<StereoCalibration>(source.calibration);
  const Camera camera = stereo.camera;
  RawStereo raw;
  raw.left = {camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px,
              RadialTangential{.k1 = -0.02}};
  raw.right = {camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px,
               RadialTangential{.k1 = 0.02}};
  raw.right_from_left.translation = {-camera.baseline_m, 0, 0};
  raw.width_px = camera.width_px;
  raw.height_px = camera.height_px;
  stereo.raw = raw;
  const std::string text = FormatRigCheck(Check(std::move(source)));
  EXPECT_THAT(text, Not(HasSubstr("RIGHT: "))) << text;
  EXPECT_THAT(text, HasSubstr("lens-rows-apart")) << text;
}

TEST(RigCheckTest, NamesASwappedPair) {
  const RigCheck check = Check(LayeredStereo(), "exchanged");
  EXPECT_FALSE(check.IsUsable());
  EXPECT_THAT(FormatRigCheck(check), HasSubstr("left and right are exchanged"));
  EXPECT_THAT(FormatRigCheck(check), HasSubstr("WRONG: "));
}

TEST(RigCheckTest, NamesRowsThatAreApart) {
  const std::string text = FormatRigCheck(Check(LayeredStereo(), "rows", 2));
  EXPECT_THAT(text, HasSubstr("rows of left and right pictures are 2.0 px apart"));
  EXPECT_THAT(text, HasSubstr("USABLE, with what is improbable above."));
}

TEST(RigCheckTest, ALatePairIsNamedFirstAndWrong) {
  const RigCheck check = Check(LayeredStereo(), "late", 1);
  EXPECT_FALSE(check.IsUsable());
  ASSERT_FALSE(check.findings.empty());
  EXPECT_EQ(check.findings[0].code, "pair-late");
  EXPECT_THAT(FormatRigCheck(check), HasSubstr("ERROR pair-late: the right camera"));
  EXPECT_THAT(FormatRigCheck(check), HasSubstr("WRONG: "));
}

// Plays a scene as a camera would, one frame each time it is asked.
class SceneStream : public client_agent::FrameStream {
 public:
  explicit SceneStream(SampleSource source) : source_(std::move(source)) {}
  const SensorCalibration& calibration() const override { return source_.calibration; }
  std::optional<double> interval_s() const override { return 0.05; }
  absl::StatusOr<client_agent::NextFrame> Next(absl::Time) override {
    if (next_ == source_.frames) return client_agent::StreamEnd();
    auto images = source_.read(next_);
    if (!images.ok()) return images.status();
    client_agent::StreamFrame frame;
    frame.frame = {next_, static_cast<int64_t>(next_) * 50'000'000, 0};
    frame.images = *std::move(images);
    ++next_;
    return frame;
  }
  client_agent::LeftOutFrames left_out() const override { return {}; }
  std::optional<client_agent::CameraCounts> camera_counts() const override {
    return client_agent::CameraCounts{.frames = next_};
  }

 private:
  const SampleSource source_;
  size_t next_ = 0;
};

TEST(RigCheckTest, LooksAtALiveCamera) {
  SceneStream stream(LayeredStereo());
  SourceDescription description;
  description.is_live = true;
  client_agent::DescribeCamera(stream.calibration(), description);
  const auto check = CheckLiveRig(stream, description, absl::Seconds(20));
  ASSERT_TRUE(check.ok()) << check.status();
  const std::string text = FormatRigCheck(*check);
  EXPECT_TRUE(check->IsUsable()) << text;
  EXPECT_THAT(text, HasSubstr("20.00 frames/s came"));
  EXPECT_THAT(text, HasSubstr("apart: the second picture of a frame is +0.00 ms later"));
  EXPECT_THAT(text, HasSubstr("rows: 0."));
  EXPECT_GT(check->regions->all.matches, 100u);
}

TEST(RigCheckTest, ShowsDepthBesideThePicture) {
  const RigCheck check = Check(LayeredRgbd());
  EXPECT_FALSE(check.regions.has_value());
  EXPECT_EQ(check.picture.cols, 2 * 640);
  EXPECT_THAT(FormatRigCheck(check), Not(HasSubstr("rows:")));
}

}  // namespace
}  // namespace corbslam::services
