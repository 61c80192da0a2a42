#include "client_agent/source/source_kinds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "client_agent/source/recorded_sequence.h"

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Plays "beacon:NAME?frames_made=N": N frames whose stamps are their numbers.
class BeaconReader : public FrameReader {
 public:
  explicit BeaconReader(size_t frames) : frames_(frames) {}

  const SensorCalibration& calibration() const override { return calibration_; }
  const SourceDescription& description() const override { return description_; }
  size_t frame_count() const override { return frames_; }
  int64_t timestamp_ns(size_t frame) const override { return static_cast<int64_t>(frame); }
  int drive(size_t /*frame*/) const override { return 0; }
  absl::StatusOr<SensorImages> Read(size_t frame) const override {
    SensorImages images;
    images.timestamp_ns = timestamp_ns(frame);
    images.grey = cv::Mat::zeros(2, 2, CV_8UC1);
    return images;
  }

 private:
  const size_t frames_;
  SensorCalibration calibration_;
  SourceDescription description_;
};

class BeaconSettings : public KindSettings {
 public:
  explicit BeaconSettings(uint32_t frames) : frames_(frames) {}

  absl::string_view kind() const override { return "beacon"; }
  std::vector<absl::string_view> OptionNames() const override { return {"frames_made"}; }
  absl::StatusOr<SharedKindSettings> With(absl::string_view key,
                                          absl::string_view value) const override {
    uint32_t frames = 0;
    if (absl::SimpleAtoi(value, &frames)) return std::make_shared<BeaconSettings>(frames);
    return absl::InvalidArgumentError(absl::StrCat(key, "=", value, ": wants a number"));
  }
  absl::Status Validate() const override {
    if (frames_ < 100) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrCat("frames_made=", frames_, ": at most 99"));
  }
  std::vector<std::pair<std::string, std::string>> FormatOptions() const override {
    if (frames_ == 0) return {};
    return {{"frames_made", absl::StrCat(frames_)}};
  }
  uint64_t noise_seed() const override { return 40 + frames_; }
  bool turned() const override { return false; }
  absl::StatusOr<std::unique_ptr<FrameReader>> Open() const override {
    return std::make_unique<BeaconReader>(frames_);
  }

 private:
  const uint32_t frames_;
};

SourceKind Beacon(const std::string& name) {
  return {name, name + ":NAME", [](absl::string_view place) -> absl::StatusOr<SharedKindSettings> {
            if (place == "lit") return std::make_shared<BeaconSettings>(0);
            return absl::InvalidArgumentError(absl::StrCat("beacon ", place, ": known is lit"));
          }};
}

// One test does it all, because what is registered stays so.
TEST(SourceKindsTest, AProgramPlaysWhatItRegistered) {
  const absl::Status unknown = ParseSourceSpec("beacon:lit").status();
  EXPECT_EQ(unknown.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(unknown.message()),
              HasSubstr("layout 'beacon': known are kitti, euroc, tum, 7scenes"));
  EXPECT_EQ(SourceUsage(), "kitti:DIR, euroc:DIR, tum:DIR or 7scenes:DIR");

  RegisterSourceKind(Beacon("beacon"));
  RegisterSourceKind(Beacon("beacon"));
  RegisterSourceKind(Beacon("tum"));
  EXPECT_THAT(KnownSourceKinds(), ElementsAre("kitti", "euroc", "tum", "7scenes", "beacon"));
  EXPECT_EQ(SourceUsage(), "kitti:DIR, euroc:DIR, tum:DIR, 7scenes:DIR or beacon:NAME");
  EXPECT_EQ(ParseSourceSpec("tum:lit")->layout, SourceLayout::kTum);

  const char* text = "beacon:lit?frames_made=5&frames=2:3";
  const SourceSpec spec = *ParseSourceSpec(text);
  EXPECT_EQ(spec.layout, SourceLayout::kRegistered);
  EXPECT_EQ(spec.perturbation.seed, 45u);
  EXPECT_EQ(FormatSourceSpec(spec), text);
  const auto source = OpenSource(spec);
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->size(), 2u);
  EXPECT_EQ((**(*source)->NextImages()).timestamp_ns, 2);

  for (const auto& [wrong, expected] :
       {std::pair("beacon:dark", "known is lit"),
        {"beacon:lit?frames_made=x", "frames_made=x"},
        {"beacon:lit?frames_made=100", "at most 99"},
        {"beacon:lit?seed=1", "frames_made"},
        {"beacon:lit?truth_frame=a", "unknown source option 'truth_frame'"}}) {
    EXPECT_THAT(std::string(ParseSourceSpec(wrong).status().message()), HasSubstr(expected));
  }
}

}  // namespace
}  // namespace corbslam::client_agent
