#include "client_agent/live/live_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <variant>

namespace corbslam::client_agent {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int64_t kFrame_ns = 50'000'000;

// Gives its pairing to the test, which pushes pictures.
class HandCamera : public LiveCamera {
 public:
  HandCamera(PicturePairing*& pairing, bool& stopped) : pairing_(pairing), stopped_(stopped) {}
  absl::Status Start(PicturePairing& pairing) override {
    pairing_ = &pairing;
    return absl::OkStatus();
  }
  void Stop() override { stopped_ = true; }

 private:
  PicturePairing*& pairing_;
  bool& stopped_;
};

Rig RectifiedPair() {
  Rig rig;
  rig.cameras = {{{100, 100, 80, 60, {}}, 160, 120}, {{100, 100, 80, 60, {}}, 160, 120}};
  rig.rectified = true;
  rig.baseline_m = 0.1;
  return rig;
}

class LiveStreamTest : public ::testing::Test {
 protected:
  void Open(const Rig& rig) {
    auto opened = LiveStream::Open(rig, std::make_unique<HandCamera>(pairing_, stopped_),
                                   {.name = "gst:test",
                                    .pair_within_ns = one_stamp_ ? 0 : 1'000'000,
                                    .one_stamp = one_stamp_});
    ASSERT_TRUE(opened.ok()) << opened.status();
    stream_ = *std::move(opened);
  }
  void Push(int64_t number, const cv::Mat& first, const cv::Mat& second) {
    pairing_->Push(LiveSide::kFirst, {number * kFrame_ns, first});
    pairing_->Push(LiveSide::kSecond, {number * kFrame_ns, second});
  }
  static cv::Mat Grey(int grey, int width = 160) { return {120, width, CV_8UC1, cv::Scalar(grey)}; }

  PicturePairing* pairing_ = nullptr;
  bool stopped_ = false;
  bool one_stamp_ = false;
  std::unique_ptr<FrameStream> stream_;
};

TEST_F(LiveStreamTest, GivesFramesAsTheyCome) {
  Open(RectifiedPair());
  auto next = stream_->Next(absl::InfinitePast());
  ASSERT_TRUE(next.ok());
  EXPECT_TRUE(std::holds_alternative<NoFrameYet>(*next));
  Push(3, Grey(40), Grey(50));
  next = stream_->Next(absl::InfinitePast());
  ASSERT_TRUE(next.ok());
  const auto& frame = std::get<StreamFrame>(*next);
  EXPECT_EQ(frame.frame.timestamp_ns, 3 * kFrame_ns);
  EXPECT_EQ(frame.images.timestamp_ns, 3 * kFrame_ns);
  EXPECT_EQ(frame.images.grey.at<uint8_t>(5, 5), 40);
  EXPECT_EQ(frame.images.right.at<uint8_t>(5, 5), 50);
  pairing_->End(absl::OkStatus());
  EXPECT_TRUE(std::holds_alternative<StreamEnd>(*stream_->Next(absl::InfiniteFuture())));
  EXPECT_TRUE(std::holds_alternative<StreamEnd>(*stream_->Next(absl::InfiniteFuture())));
  stream_.reset();
  EXPECT_TRUE(stopped_);
}

// Of a camera that gives pictures alone, nobody may wait for samples.
TEST_F(LiveStreamTest, SaysThatARigsImuIsNotUsed) {
  Rig rig = RectifiedPair();
  rig.imu.emplace();
  Open(rig);
  EXPECT_FALSE(std::get<StereoCalibration>(stream_->calibration()).imu.has_value());
  ASSERT_EQ(stream_->findings().size(), 1u);
  EXPECT_EQ(stream_->findings()[0].code, "imu-unused");
  EXPECT_THAT(stream_->findings()[0].text, HasSubstr("gst:test: the rig's IMU is not used"));
}

TEST_F(LiveStreamTest, SaysHowManyFramesARobotMissed) {
  Open(RectifiedPair());
  for (int i = 1; i <= 6; ++i) Push(i, Grey(i), Grey(i));
  const auto next = stream_->Next(absl::InfinitePast());
  EXPECT_EQ(std::get<StreamFrame>(*next).frame.number, 5u);
  EXPECT_EQ(stream_->overtaken(), 5u);
  EXPECT_EQ(stream_->left_out().count, 0u);
}

TEST_F(LiveStreamTest, AnotherClockThatStaysIsAnotherDrive) {
  Open(RectifiedPair());
  for (int i = 0; i < 3; ++i) Push(1000 + i, Grey(1), Grey(1));
  EXPECT_EQ(std::get<StreamFrame>(*stream_->Next(absl::InfinitePast())).frame.drive, 0);
  for (int i = 0; i < 10; ++i) Push(i, Grey(2), Grey(2));
  const auto next = stream_->Next(absl::InfinitePast());
  const auto& frame = std::get<StreamFrame>(*next);
  EXPECT_EQ(frame.frame.drive, 1);
  EXPECT_EQ(frame.frame.timestamp_ns, 9 * kFrame_ns);
  EXPECT_THAT(stream_->left_out().last, HasSubstr("came behind a newer one"));
}

// Both cameras take a picture each 50 ms, 20 ms after each other.
TEST_F(LiveStreamTest, CamerasThatRunFreelyEndItWithWhatHelps) {
  Open(RectifiedPair());
  absl::StatusOr<NextFrame> next = NoFrameYet();
  int pictures = 0;
  while (next.ok() && pictures < 200) {
    const int64_t time_ns = ++pictures * kFrame_ns;
    pairing_->Push(LiveSide::kFirst, {time_ns, Grey(1)});
    pairing_->Push(LiveSide::kSecond, {time_ns + 20'000'000, Grey(1)});
    next = stream_->Next(absl::InfinitePast());
  }
  EXPECT_TRUE(absl::IsInvalidArgument(next.status())) << next.status();
  EXPECT_THAT(std::string(next.status().message()),
              AllOf(HasSubstr("no two of one time; the nearest are 20.0 ms apart, a frame's may be "
                              "1.0 ms: do the cameras run freely?"),
                    HasSubstr("time_offset_s")));
  EXPECT_EQ(pictures, 50);
  EXPECT_THAT(stream_->left_out().last, HasSubstr("do the cameras run freely?"));
}

// One camera is slow to start: the other waits for it.
TEST_F(LiveStreamTest, ACameraThatGivesNothingYetIsWaitedFor) {
  Open(RectifiedPair());
  for (int i = 1; i < 200; ++i) {
    pairing_->Push(LiveSide::kFirst, {i * kFrame_ns, Grey(1)});
    ASSERT_TRUE(stream_->Next(absl::InfinitePast()).ok());
  }
  Push(200, Grey(1), Grey(1));
  const auto next = stream_->Next(absl::InfinitePast());
  EXPECT_TRUE(next.ok() && std::holds_alternative<StreamFrame>(*next));
}

TEST_F(LiveStreamTest, PicturesOfAnotherSizeEndItWithWhatWasWanted) {
  Open(RectifiedPair());
  absl::StatusOr<NextFrame> next = NoFrameYet();
  for (int i = 1; i <= 10 && next.ok(); ++i) {
    Push(i, Grey(1, 320), Grey(1, 320));
    next = stream_->Next(absl::InfinitePast());
  }
  EXPECT_TRUE(absl::IsInvalidArgument(next.status())) << next.status();
  EXPECT_THAT(
      std::string(next.status().message()),
      HasSubstr("gst:test: frame 9: a left picture of 320x120 CV_8UC1, the rig is of 160x120"));
  EXPECT_EQ(stream_->left_out().count, 10u);
  EXPECT_TRUE(std::holds_alternative<StreamEnd>(*stream_->Next(absl::InfiniteFuture())));
}

TEST_F(LiveStreamTest, ACamerasErrorIsItsLastWord) {
  Open(RectifiedPair());
  pairing_->End(absl::UnavailableError("unplugged"));
  EXPECT_EQ(stream_->Next(absl::InfiniteFuture()).status().message(), "unplugged");
  EXPECT_TRUE(std::holds_alternative<StreamEnd>(*stream_->Next(absl::InfiniteFuture())));
}

TEST_F(LiveStreamTest, DepthIsOfSixteenBits) {
  Rig rig;
  rig.kind = RigKind::kRgbd;
  rig.cameras = {{{100, 100, 80, 60, {}}, 160, 120}};
  rig.rate_hz = 25;
  Open(rig);
  EXPECT_EQ(stream_->interval_s(), 0.04);
  Push(1, Grey(7), cv::Mat(120, 160, CV_16UC1, cv::Scalar(900)));
  const auto next = stream_->Next(absl::InfinitePast());
  const auto& frame = std::get<StreamFrame>(*next);
  EXPECT_EQ(frame.images.depth.at<uint16_t>(1, 1), 900);
  EXPECT_TRUE(frame.images.right.empty());
  Push(2, Grey(7), Grey(7));
  EXPECT_TRUE(std::holds_alternative<NoFrameYet>(*stream_->Next(absl::InfinitePast())));
  EXPECT_THAT(stream_->left_out().last, HasSubstr("a depth picture of 160x120 CV_8UC1"));
}

TEST_F(LiveStreamTest, DepthOfACameraOfItsOwnIsRegistered) {
  Rig rig;
  rig.kind = RigKind::kRgbd;
  rig.cameras = {{{100, 100, 80, 60, {}}, 160, 120}};
  rig.depth.camera = RigCamera{{50, 50, 39.75, 29.75, {}}, 80, 60};
  Open(rig);
  Push(1, Grey(7), cv::Mat(60, 80, CV_16UC1, cv::Scalar(900)));
  const auto next = stream_->Next(absl::InfinitePast());
  ASSERT_TRUE(next.ok() && std::holds_alternative<StreamFrame>(*next)) << next.status();
  const cv::Mat& depth = std::get<StreamFrame>(*next).images.depth;
  EXPECT_EQ(depth.size(), cv::Size(160, 120));
  EXPECT_EQ(depth.at<uint16_t>(100, 1), 900);
  Push(2, Grey(7), cv::Mat(120, 160, CV_16UC1, cv::Scalar(900)));
  EXPECT_TRUE(std::holds_alternative<NoFrameYet>(*stream_->Next(absl::InfinitePast())));
  EXPECT_THAT(stream_->left_out().last, HasSubstr("the rig is of 80x60"));
}

// What calibrators always leave, 0.1 ms, must not part the two halves of one picture.
TEST_F(LiveStreamTest, AnOffsetWithinOneStampIsNotUsedAndThatIsSaid) {
  Rig rig = RectifiedPair();
  rig.cameras[1].time_offset_s = 1e-4;
  one_stamp_ = true;
  Open(rig);
  Push(1, Grey(40), Grey(50));
  EXPECT_TRUE(std::holds_alternative<StreamFrame>(*stream_->Next(absl::InfinitePast())));
  EXPECT_EQ(stream_->left_out().count, 0u);
  ASSERT_EQ(stream_->findings().size(), 1u);
  EXPECT_EQ(stream_->findings()[0].code, "time-offset-unused");
  EXPECT_THAT(stream_->findings()[0].text, HasSubstr("0.1 ms later"));

  one_stamp_ = false;
  rig.cameras[1].time_offset_s = 0.012;
  Open(rig);
  EXPECT_TRUE(stream_->findings().empty());
  Push(1, Grey(40), Grey(50));
  EXPECT_TRUE(std::holds_alternative<NoFrameYet>(*stream_->Next(absl::InfinitePast())));
}

TEST_F(LiveStreamTest, ACheckRefusesWhatOpeningWould) {
  EXPECT_TRUE(LiveStream::Check(RectifiedPair(), {.name = "gst:test"}).ok());
  EXPECT_THAT(LiveStream::Check(RectifiedPair(), {.name = "gst:test", .registers = true}).message(),
              HasSubstr("register=1 is of RGB-D rigs"));
  Rig rig;
  rig.kind = RigKind::kRgbd;
  rig.cameras = {{{100, 100, 80, 60, {}}, 160, 120}};
  EXPECT_THAT(LiveStream::Check(rig, {.name = "gst:test", .registers = true}).message(),
              HasSubstr("through which lens"));
}

TEST_F(LiveStreamTest, RefusesAnImpossibleRig) {
  Rig rig = RectifiedPair();
  rig.baseline_m = -1;
  EXPECT_THAT(std::string(LiveStream::Open(rig, std::make_unique<HandCamera>(pairing_, stopped_),
                                           {"gst:test", 1'000'000})
                              .status()
                              .message()),
              HasSubstr("baseline_m is -1"));
}

}  // namespace
}  // namespace corbslam::client_agent
