#include "services/programs/robot/pictures_time.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "client_agent/source/recorded_sequence.h"

namespace corbslam::services {

using client_agent::LeftOutFrames;
using client_agent::NextFrame;
using client_agent::RecordedSequence;
using client_agent::SourceFrame;
using client_agent::StreamEnd;

namespace {

// A sequence that has times and no pictures.
class TimedSource : public RecordedSequence {
 public:
  explicit TimedSource(std::vector<SourceFrame> frames) : frames_(std::move(frames)) {}

  const SensorCalibration& calibration() const override { return calibration_; }
  size_t size() const override { return frames_.size(); }
  SourceFrame frame(size_t i) const override { return frames_.at(i); }
  absl::StatusOr<NextFrame> Next(absl::Time /*deadline*/) override { return StreamEnd(); }
  LeftOutFrames left_out() const override { return {}; }

 private:
  std::vector<SourceFrame> frames_;
  SensorCalibration calibration_;
};

TimedSource MakeSource(const std::vector<double>& times_s, int drive = 0) {
  std::vector<SourceFrame> frames;
  for (const double time_s : times_s) {
    frames.push_back({frames.size(), static_cast<int64_t>(time_s * 1e9), drive});
  }
  return TimedSource(std::move(frames));
}

TEST(PicturesTimeTest, IsThatOfItsFrames) {
  const TimedSource source = MakeSource({10, 10.1, 10.2, 10.3, 10.4});
  EXPECT_NEAR(PicturesTime_s(source, 5), 0.5, 1e-9);
  EXPECT_NEAR(PicturesTime_s(source, 2), 0.2, 1e-9) << "it was stopped early";
  EXPECT_EQ(PicturesTime_s(source, 0), 0);
}

TEST(PicturesTimeTest, PausesAndPlayingBackwardsDoNotCount) {
  EXPECT_NEAR(PicturesTime_s(MakeSource({0, 0.5, 1, 3600, 3600.5}), 5), 2.5, 1e-9);
  EXPECT_NEAR(PicturesTime_s(MakeSource({2, 1.5, 1, 0.5}), 4), 2, 1e-9);
}

TEST(PicturesTimeTest, FramesOfTwoDrivesHaveNoIntervalBetweenThem) {
  TimedSource two({{0, 5'000'000'000, 0}, {1, 0, 1}});
  EXPECT_EQ(PicturesTime_s(two, 2), 0);
  EXPECT_EQ(PicturesTime_s(MakeSource({}), 0), 0);
  EXPECT_EQ(PicturesTime_s(MakeSource({7}), 1), 0);
}

}  // namespace
}  // namespace corbslam::services
