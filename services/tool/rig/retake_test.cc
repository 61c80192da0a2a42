#include "services/tool/rig/retake.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <variant>

#include "client_agent/source_checks/testing/layered_scene.h"
#include "client_agent/source_checks/testing/sample_source.h"
#include "services/tool/rig/pair_regions.h"

namespace corbslam::services {
namespace {

using client_agent::FrameReader;
using client_agent::LayeredStereo;
using client_agent::OpenReader;
using client_agent::PairPreparation;
using client_agent::ParseSourceSpec;
using client_agent::Rig;
using client_agent::SampleSource;
using client_agent::SourceDescription;
using client_agent::SourceSpec;
using ::testing::HasSubstr;

// Three frames of a scene of cards, 640 x 360 pixels.
class Scene : public FrameReader {
 public:
  Scene() : source_(LayeredStereo()) {}
  const SensorCalibration& calibration() const override { return source_.calibration; }
  const SourceDescription& description() const override { return description_; }
  size_t frame_count() const override { return 3; }
  int64_t timestamp_ns(size_t frame) const override {
    return static_cast<int64_t>(frame) * 50'000'000;
  }
  int drive(size_t) const override { return 0; }
  absl::StatusOr<SensorImages> Read(size_t frame) const override { return source_.read(frame); }

 private:
  const SampleSource source_;
  SourceDescription description_;
};

// Cameras that are turned against each other by two degrees.
Rig RigOf(const LensModel& lens, double focal_px) {
  Rig rig;
  for (int i = 0; i < 2; ++i) {
    rig.cameras.push_back({{focal_px, focal_px, 315.0 + 6 * i, 183.0 - 4 * i, lens}, 640, 360});
  }
  rig.right_from_left.rotation = Eigen::AngleAxisd(0.035, Eigen::Vector3d(2, 1, 3).normalized());
  rig.right_from_left.translation = {-0.1, 0.001, 0};
  rig.widest_field_deg = 60;
  return rig;
}

std::string FreshFolder(const std::string& name) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / name;
  std::filesystem::remove_all(folder);
  return folder.string();
}

// What was taken through a lens and askew is a rectified pair again when it is played.
TEST(RetakeTest, RectificationUndoesIt) {
  const std::pair<LensModel, double> lenses[] = {
      {RadialTangential{-0.28, 0.07, 0.0002, 0.00002, 0}, 500},
      {Equidistant{0.003, -0.002, 0.001, 0}, 420},
      {DoubleSphere{-0.1, 0.55}, 350},
      {UnifiedSphere{1.1, {}}, 900}};
  const Scene scene;
  for (const auto& [lens, focal_px] : lenses) {
    const std::string folder = FreshFolder("retaken");
    const auto frames = Retake(scene, SourceSpec(), RigOf(lens, focal_px), folder);
    ASSERT_TRUE(frames.ok()) << frames.status();
    EXPECT_EQ(*frames, 3u);
    const auto spec =
        ParseSourceSpec("kitti:" + folder + "?trust_calibration=1&rig=" + folder + "/rig.yaml");
    ASSERT_TRUE(spec.ok()) << spec.status();
    const auto reader = OpenReader(*spec);
    ASSERT_TRUE(reader.ok()) << reader.status();
    EXPECT_EQ((*reader)->timestamp_ns(2), 100'000'000);
    const auto preparation =
        PairPreparation::Make(std::get<StereoCalibration>((*reader)->calibration()));
    ASSERT_TRUE(preparation.ok()) << preparation.status();
    client_agent::Sample sample;
    for (size_t i = 0; i < 3; ++i) sample.push_back({i, (*reader)->Read(i).value()});
    const auto measured = MeasureRegions(*preparation, preparation->Judge(sample));
    EXPECT_GT(measured.all.matches, 150u) << NameOf(lens);
    EXPECT_LT(measured.all.row_error_px, 0.5) << NameOf(lens);
    EXPECT_LT(measured.negative_share, 0.1) << NameOf(lens);
  }
}

TEST(RetakeTest, RefusesWhatItCannotTakeAgain) {
  const Scene scene;
  const std::string folder = FreshFolder("retaken_not");
  Rig rig = RigOf(RadialTangential(), 500);
  rig.right_from_left.translation *= 2;
  EXPECT_THAT(std::string(Retake(scene, SourceSpec(), rig, folder).status().message()),
              HasSubstr("m apart, those of the recording 0.1"));
  rig.rectified = true;
  EXPECT_THAT(std::string(Retake(scene, SourceSpec(), rig, folder).status().message()),
              HasSubstr("not rectified"));
}

}  // namespace
}  // namespace corbslam::services
