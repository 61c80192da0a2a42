#include "services/tool/rig/live_sample.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace corbslam::services {

using client_agent::CameraCounts;
using client_agent::FrameStream;
using client_agent::LeftOutFrames;
using client_agent::NextFrame;
using client_agent::SampleOptions;
using client_agent::SourceFinding;
using client_agent::SourceFindings;
using client_agent::StreamEnd;
using client_agent::StreamFrame;

namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Gives frames at once, of the times and numbers that it is told, then what it ends with.
class ListedStream : public FrameStream {
 public:
  explicit ListedStream(std::vector<std::pair<size_t, int64_t>> frames)
      : frames_(std::move(frames)) {}
  const SensorCalibration& calibration() const override { return calibration_; }
  std::optional<double> interval_s() const override { return 0.05; }
  absl::StatusOr<NextFrame> Next(absl::Time) override {
    if (at_ == frames_.size()) {
      if (!end.ok()) return end;
      return StreamEnd();
    }
    StreamFrame frame;
    frame.frame = {frames_[at_].first, frames_[at_].second * 1'000'000, at_ < clock_until ? 0 : 1};
    ++at_;
    return frame;
  }
  LeftOutFrames left_out() const override { return {}; }
  std::optional<CameraCounts> camera_counts() const override { return counts; }

  CameraCounts counts;
  size_t clock_until = 1000;  // From this frame on times go by another clock.
  absl::Status end;

 private:
  const SensorCalibration calibration_ = StereoCalibration();
  const std::vector<std::pair<size_t, int64_t>> frames_;
  size_t at_ = 0;
};

// Twenty frames a second; the fifth to seventh were overtaken, and one came 70 ms late.
std::vector<std::pair<size_t, int64_t>> Times() {
  std::vector<std::pair<size_t, int64_t>> times;
  for (size_t i = 0; i < 40; ++i) {
    if (i >= 5 && i <= 7) continue;
    times.emplace_back(i, 50 * static_cast<int64_t>(i) + (i >= 30 ? 70 : 0));
  }
  return times;
}

constexpr SampleOptions kOnePlace = {.places = 1, .stereo_row = 3, .rgbd_row = 5};

TEST(LiveSampleTest, MeasuresRateAndGapsByTheFramesOwnTimes) {
  ListedStream stream(Times());
  const auto sample = TakeLiveSample(stream, absl::Seconds(20), kOnePlace);
  ASSERT_TRUE(sample.ok()) << sample.status();
  EXPECT_EQ(sample->taken, 37u);
  EXPECT_EQ(sample->frames.size(), 3u);
  EXPECT_NEAR(sample->rate_hz, 39 / 2.02, 1e-9);
  EXPECT_EQ(sample->gaps, 1u) << "what was overtaken is no gap";
  EXPECT_NEAR(sample->longest_s, 0.12, 1e-9);
  EXPECT_THAT(CheckLiveSample(*sample, 20), IsEmpty());
  const auto lines = DescribeInLines(*sample);
  EXPECT_EQ(lines[0].second, "37 taken in 2.0 s, 19.31 frames/s came");
}

TEST(LiveSampleTest, TellsOfTimesByAnotherClock) {
  ListedStream stream({{0, 9000}, {1, 9050}, {2, 100}, {3, 150}, {4, 200}});
  stream.clock_until = 2;
  const auto sample = TakeLiveSample(stream, absl::Seconds(20), kOnePlace);
  ASSERT_TRUE(sample.ok()) << sample.status();
  EXPECT_NEAR(sample->rate_hz, 20, 1e-9);
  const SourceFindings findings = CheckLiveSample(*sample, std::nullopt);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].code, "camera-clock");
  EXPECT_THAT(findings[0].text, HasSubstr("by 2 clocks"));
}

TEST(LiveSampleTest, TellsWhatIsWrongWithTheCamera) {
  ListedStream stream({{0, 0}, {1, 50}, {2, 100}, {3, 200}, {4, 250}});
  stream.end = absl::UnavailableError("unplugged");
  stream.counts = {.frames = 5,
                   .overtaken = 1,
                   .unpaired = 9,
                   .late = 0,
                   .mean_apart_ns = 4000000,
                   .most_apart_ns = 4900000};
  const auto sample = TakeLiveSample(stream, absl::Seconds(20), kOnePlace);
  ASSERT_TRUE(sample.ok()) << sample.status();
  std::vector<std::string> codes;
  for (const SourceFinding& finding : CheckLiveSample(*sample, 30)) codes.push_back(finding.code);
  EXPECT_THAT(codes, ::testing::ElementsAre("camera-failed", "camera-slow", "camera-gaps",
                                            "pair-unpaired"));
  EXPECT_THAT(DescribeInLines(*sample)[3].second, HasSubstr("+4.00 ms later"));
}

TEST(LiveSampleTest, ACameraWithoutFramesIsAnError) {
  ListedStream empty({});
  EXPECT_THAT(std::string(TakeLiveSample(empty, absl::Seconds(20), {}).status().message()),
              HasSubstr("gave no frame in 20s"));
  empty.end = absl::InvalidArgumentError("pictures of another size");
  EXPECT_EQ(TakeLiveSample(empty, absl::Seconds(20), {}).status(), empty.end);
}

}  // namespace
}  // namespace corbslam::services
