#include "client_agent/live/gstreamer/gst_source.h"

#include <glog/logging.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/time/clock.h"
#include "client_agent/live/gstreamer/testing/open_live.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/frame_stream.h"
#include "client_agent/source/source_spec.h"

namespace corbslam::client_agent {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::kSmallStereoRig;
using testing::OpenLive;

constexpr char kRgbd[] =
    "rig: 1\nkind: rgbd\ndepth: {units_per_m: 1000}\ncameras:\n"
    "  - {size_px: [160, 120], focal_px: [100, 100], principal_px: [80, 60]}\n";

// A camera of GStreamer's own, at 20 frames/s of its time, in real time where it is asked to be.
std::string TestCamera(int frames, const std::string& more = "", int width = 160) {
  return absl::StrCat("videotestsrc num-buffers=", frames, " ", more,
                      " ! video/x-raw,width=", width, ",height=120,framerate=20/1");
}

std::string WriteRig(const std::string& text) {
  const std::string path = ::testing::TempDir() + "/gst_rig.yaml";
  std::ofstream(path) << text;
  return path;
}

// Returns what is known of a source without its camera.
absl::Status Check(const std::string& source) {
  RegisterGstSources();
  const auto spec = ParseSourceSpec(source);
  return spec.ok() ? spec->settings->CheckLive() : spec.status();
}

struct Played {
  std::vector<StreamFrame> frames;
  absl::Status end;
  // Frames that came, taken or not: a busy machine overtakes some.
  size_t came = 0;
};

// Plays until the stream's end, or for twenty seconds.
Played Play(FrameStream& stream, size_t most = 1000) {
  Played played;
  const absl::Time deadline = absl::Now() + absl::Seconds(20);
  while (absl::Now() < deadline && played.frames.size() < most) {
    auto next = stream.Next(absl::Now() + absl::Milliseconds(100));
    played.end = next.status();
    if (!next.ok() || std::holds_alternative<StreamEnd>(*next)) break;
    if (auto* frame = std::get_if<StreamFrame>(&*next)) played.frames.push_back(std::move(*frame));
  }
  played.came = played.frames.size() + stream.overtaken();
  return played;
}

class Listener : public google::LogSink {
 public:
  explicit Listener(std::string text) : text_(std::move(text)) { google::AddLogSink(this); }
  ~Listener() override { google::RemoveLogSink(this); }
  void send(google::LogSeverity, const char*, const char*, int, const struct ::tm*,
            const char* message, size_t length) override {
    told_ += absl::StrContains(absl::string_view(message, length), text_) ? 1 : 0;
  }
  int told() const { return told_; }

 private:
  const std::string text_;
  std::atomic<int> told_ = 0;
};

// Two pipelines begin apart by what the machine is busy with: here half a frame may lie between
// them.
TEST(GstSourceTest, TwoPipelinesAreAPair) {
  const auto stream = OpenLive(absl::StrCat("gst:", TestCamera(12, "is-live=true pattern=white"),
                                            " || ", TestCamera(12, "is-live=true pattern=black"),
                                            "?pair_within_ms=25&rig=", WriteRig(kSmallStereoRig)));
  ASSERT_TRUE(stream.ok()) << stream.status();
  const Played played = Play(**stream);
  EXPECT_TRUE(played.end.ok()) << played.end;
  // A live source in real time: a picture may be lost at its start, no more.
  ASSERT_GE(played.came, 9u);
  ASSERT_GE(played.frames.size(), 1u);
  for (size_t i = 0; i < played.frames.size(); ++i) {
    const SensorImages& images = played.frames[i].images;
    EXPECT_EQ(images.grey.type(), CV_8UC1);
    EXPECT_EQ(images.grey.cols, 160);
    EXPECT_GT(images.grey.at<uint8_t>(60, 80), 200);
    EXPECT_LT(images.right.at<uint8_t>(60, 80), 50);
    if (i == 0) continue;
    const int64_t step_ns = images.timestamp_ns - played.frames[i - 1].images.timestamp_ns;
    EXPECT_NEAR(static_cast<double>(step_ns % 50'000'000), 0, 50e6) << "at " << i;
    EXPECT_GT(step_ns, 20'000'000);
  }
}

TEST(GstSourceTest, OnePictureHoldsBothHalves) {
  for (const std::string layout : {"side-by-side", "one-above"}) {
    const std::string camera = layout == "side-by-side"
                                   ? TestCamera(8, "is-live=true pattern=gradient", 320)
                                   : "videotestsrc num-buffers=8 is-live=true pattern=gradient ! "
                                     "video/x-raw,width=160,height=240,framerate=20/1";
    const auto stream = OpenLive(
        absl::StrCat("gst:", camera, "?layout=", layout, "&rig=", WriteRig(kSmallStereoRig)));
    ASSERT_TRUE(stream.ok()) << stream.status();
    const Played played = Play(**stream);
    ASSERT_GE(played.came, 5u) << layout;
    ASSERT_GE(played.frames.size(), 1u);
    const SensorImages& images = played.frames.back().images;
    EXPECT_EQ(images.right.size(), images.grey.size());
    // The gradient runs downwards: halves side by side are alike, one above the other are not.
    const int top = images.grey.at<uint8_t>(10, 80);
    const int other = images.right.at<uint8_t>(10, 80);
    if (layout == "side-by-side") {
      EXPECT_EQ(top, other);
    } else {
      EXPECT_GT(std::abs(top - other), 60);
    }
  }
}

TEST(GstSourceTest, DepthComesAsASecondPipeline) {
  const auto stream =
      OpenLive(absl::StrCat("gst:", TestCamera(8, "is-live=true"),
                            " || videotestsrc num-buffers=8 is-live=true pattern=white ! "
                            "video/x-raw,format=GRAY16_LE,width=160,height=120,framerate=20/1",
                            "?pair_within_ms=25&rig=", WriteRig(kRgbd)));
  ASSERT_TRUE(stream.ok()) << stream.status();
  const Played played = Play(**stream);
  ASSERT_GE(played.came, 5u);
  ASSERT_GE(played.frames.size(), 1u);
  EXPECT_EQ(played.frames[0].images.depth.type(), CV_16UC1);
  EXPECT_GT(played.frames[0].images.depth.at<uint16_t>(3, 3), 50000);
}

// Writes pictures whose numbers can be told from their pixels, and returns the pipeline that plays
// them at 20 a second.
std::string Pictures(const std::string& name, const cv::Size& size, int type) {
  const std::string folder = absl::StrCat(::testing::TempDir(), "/gst_", name);
  std::filesystem::create_directories(folder);
  for (int i = 0; i < 8; ++i) {
    cv::Mat picture(size, type);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        if (type == CV_16UC1) {
          picture.at<uint16_t>(y, x) = static_cast<uint16_t>(1000 + 700 * i + 3 * x + 41 * y);
        } else {
          picture.at<uint8_t>(y, x) = static_cast<uint8_t>(20 * i + (x + y) % 16);
        }
      }
    }
    cv::imwrite(absl::StrCat(folder, "/", i, ".png"), picture);
  }
  return absl::StrCat("multifilesrc location=", folder,
                      "/%d.png index=0 stop-index=7 caps=image/png,framerate=20/1 ! pngdec ! "
                      "identity sync=true");
}

// Grey and depth come as they were recorded, to the bit, each with the other's.
TEST(GstSourceTest, RecordedDepthIsTheSameToTheBit) {
  const auto stream =
      OpenLive(absl::StrCat("gst:", Pictures("grey", {160, 120}, CV_8UC1), " || ",
                            Pictures("depth", {160, 120}, CV_16UC1), "?rig=", WriteRig(kRgbd)));
  ASSERT_TRUE(stream.ok()) << stream.status();
  const Played played = Play(**stream);
  EXPECT_TRUE(played.end.ok()) << played.end;
  ASSERT_GE(played.frames.size(), 2u);
  for (const StreamFrame& frame : played.frames) {
    const int number = frame.images.grey.at<uint8_t>(0, 0) / 20;
    for (const auto& [name, picture] :
         {std::pair("grey", frame.images.grey), {"depth", frame.images.depth}}) {
      const cv::Mat recorded =
          cv::imread(absl::StrCat(::testing::TempDir(), "/gst_", name, "/", number, ".png"),
                     cv::IMREAD_UNCHANGED);
      ASSERT_EQ(picture.type(), recorded.type());
      EXPECT_EQ(cv::norm(picture, recorded, cv::NORM_INF), 0) << name << " " << number;
    }
  }
}

// Depth of another camera, of another size and stamped 0.3 s early.
TEST(GstSourceTest, DepthIsRegisteredByTheRig) {
  const std::string rig = absl::StrReplaceAll(
      kRgbd, {{"{units_per_m: 1000}",
               "{units_per_m: 1000, time_offset_s: 0.3, camera: {size_px: [80, 60], focal_px: "
               "[50, 50], principal_px: [39.75, 29.75]}, colour_from_depth: [1, 0, 0, 0, 0, 1, 0, "
               "0, 0, 0, 1, 0, 0, 0, 0, 1]}"}});
  const auto stream =
      OpenLive(absl::StrCat("gst:", Pictures("grey", {160, 120}, CV_8UC1), " || ",
                            Pictures("small", {80, 60}, CV_16UC1), "?rig=", WriteRig(rig)));
  ASSERT_TRUE(stream.ok()) << stream.status();
  const Played played = Play(**stream);
  ASSERT_GE(played.frames.size(), 1u);
  for (const StreamFrame& frame : played.frames) {
    ASSERT_EQ(frame.images.depth.size(), cv::Size(160, 120));
    EXPECT_EQ(cv::countNonZero(frame.images.depth), 160 * 120);
    // The depth image was taken six frames of 50 ms after the grey one of the same stamp.
    const int grey = frame.images.grey.at<uint8_t>(0, 0) / 20;
    EXPECT_EQ(frame.images.depth.at<uint16_t>(0, 0), 1000 + 700 * (grey - 6));
  }
  EXPECT_THAT(std::string(OpenLive(absl::StrCat("gst:", TestCamera(3), " || ", TestCamera(3),
                                                "?register=1&rig=", WriteRig(kRgbd)))
                              .status()
                              .message()),
              HasSubstr("the rig must say through which lens it is measured"));
}

// A device that goes away and comes back: one stream, whose times go on.
TEST(GstSourceTest, ACameraThatWentAwayIsWaitedFor) {
  const auto stream =
      OpenLive(absl::StrCat("gst:", TestCamera(6, "is-live=true", 320),
                            "?restart=1&layout=side-by-side&rig=", WriteRig(kSmallStereoRig)));
  ASSERT_TRUE(stream.ok()) << stream.status();
  const Played played = Play(**stream, 11);
  ASSERT_EQ(played.frames.size(), 11u) << played.end;
  int64_t longest_ns = 0;
  for (size_t i = 1; i < played.frames.size(); ++i) {
    const int64_t step_ns =
        played.frames[i].images.timestamp_ns - played.frames[i - 1].images.timestamp_ns;
    EXPECT_GT(step_ns, 0);
    longest_ns = std::max(longest_ns, step_ns);
  }
  EXPECT_GT(longest_ns, 900'000'000);
  EXPECT_LT(longest_ns, 10'000'000'000);
}

// Such times are those of the machine's monotonic clock, as the times that other pictures have.
TEST(GstSourceTest, PicturesWithoutTimesHaveThoseAtWhichTheyCameAndItIsSaidOnce) {
  const Listener listener("gives no times");
  const auto stream =
      OpenLive(absl::StrCat("gst:fakesrc format=time sizetype=fixed sizemax=38400 num-buffers=8 ! "
                            "video/x-raw,format=GRAY8,width=320,height=120,framerate=20/1 ! "
                            "identity sleep-time=20000?layout=side-by-side&rig=",
                            WriteRig(kSmallStereoRig)));
  ASSERT_TRUE(stream.ok()) << stream.status();
  const Played played = Play(**stream);
  EXPECT_TRUE(played.end.ok()) << played.end;
  ASSERT_GE(played.frames.size(), 1u);
  EXPECT_EQ(listener.told(), 1);
  const int64_t now_ns = std::chrono::steady_clock::now().time_since_epoch().count();
  for (const StreamFrame& frame : played.frames) {
    EXPECT_LE(frame.images.timestamp_ns, now_ns);
    EXPECT_GT(frame.images.timestamp_ns, now_ns - 60'000'000'000);
  }
}

// Of two pipelines one ends, and the other would go on for good.
TEST(GstSourceTest, OneSidesEndIsAnEnd) {
  const std::string source =
      absl::StrCat("gst:", TestCamera(1000, "is-live=true"), " || ", TestCamera(4, "is-live=true"),
                   "?rig=", WriteRig(kSmallStereoRig));
  const auto stream = OpenLive(source);
  ASSERT_TRUE(stream.ok()) << stream.status();
  const absl::Status end = Play(**stream).end;
  EXPECT_THAT(
      std::string(end.message()),
      HasSubstr("the right pipeline ended after 4 pictures, and the left pipeline goes on"));
  const auto restarts = OpenLive(source + "&restart=1&pair_within_ms=25");
  ASSERT_TRUE(restarts.ok()) << restarts.status();
  const Played played = Play(**restarts, 5);
  EXPECT_EQ(played.frames.size(), 5u) << played.end;
}

TEST(GstSourceTest, AnErrorNamesItsElementAndItsSide) {
  const auto stream = OpenLive(
      absl::StrCat("gst:", TestCamera(20), " || ", TestCamera(20),
                   " ! identity name=broken error-after=4?rig=", WriteRig(kSmallStereoRig)));
  const absl::Status end = stream.ok() ? Play(**stream).end : stream.status();
  EXPECT_THAT(std::string(end.message()), HasSubstr("the right pipeline: broken: "));
}

// The side of a picture that is cut short, and its element, are named.
TEST(GstSourceTest, ACutPictureIsSaid) {
  const Listener listener("the left pipeline");
  const std::string left = Pictures("cut", {160, 120}, CV_8UC1);
  const std::string cut = absl::StrCat(::testing::TempDir(), "/gst_cut/4.png");
  std::filesystem::resize_file(cut, std::filesystem::file_size(cut) / 2);
  const auto stream =
      OpenLive(absl::StrCat("gst:", left, " || ", Pictures("whole", {160, 120}, CV_8UC1),
                            "?rig=", WriteRig(kSmallStereoRig)));
  ASSERT_TRUE(stream.ok()) << stream.status();
  const Played played = Play(**stream);
  EXPECT_TRUE(listener.told() > 0 || absl::StrContains(played.end.message(), "the left pipeline"))
      << played.end;
}

// What ends by itself has no more to give, unless somebody says otherwise.
TEST(GstSourceTest, AFileEndsTheStream) {
  const auto stream = OpenLive(absl::StrCat(
      "gst:", TestCamera(5, "", 320), "?layout=side-by-side&rig=", WriteRig(kSmallStereoRig)));
  ASSERT_TRUE(stream.ok()) << stream.status();
  const Played played = Play(**stream);
  EXPECT_TRUE(played.end.ok()) << played.end;
  EXPECT_GE(played.frames.size(), 1u) << "as fast as it can: newer frames replace those not taken";
}

TEST(GstSourceTest, SaysWhatIsWrong) {
  const std::string rig = WriteRig(kSmallStereoRig);
  const struct {
    std::string source, says;
  } cases[] = {
      {"gst:nosuchelement?layout=side-by-side&rig=" + rig, "nosuchelement"},
      {"gst:foo ! bar || baz?rig=" + rig, "foo"},
      {"gst:videotestsrc || videotestsrc?register=1&rig=" + rig, "register=1 is of RGB-D rigs"},
      {"gst:videotestsrc?rig=" + rig, "a frame has two pictures: name a second camera"},
      {"gst:videotestsrc?layout=side-by-side", "a live camera needs its rig"},
      {"gst:videotestsrc?layout=diagonal&rig=" + rig, "wants side-by-side or one-above"},
      {"gst:?layout=side-by-side&rig=" + rig, "names no camera: give a pipeline as gst-launch-1.0"},
      {"gst:videotestsrc || ?rig=" + rig, "names no second camera"},
      {"gst: || videotestsrc?rig=" + rig, "names no first camera"},
      {"gst:videotestsrc ! autovideosink?layout=side-by-side&rig=" + rig,
       "ends in a sink, autovideosink: leave it out"},
      {"gst:videotestsrc ! appsink?layout=side-by-side&rig=" + rig, "ends in a sink, appsink"},
      {"gst:videotestsrc || videotestsrc ! fakesink?rig=" + rig, "ends in a sink, fakesink"},
      {"v4l2:?layout=side-by-side&rig=" + rig, "names no camera: give devices"},
      {"v4l2:/dev/video0,?rig=" + rig, "names no second camera"},
      {"v4l2:/dev/video0,/dev/../dev/video0?rig=" + rig, "names the same camera twice"},
      {"gst:videotestsrc || videotestsrc?layout=side-by-side&rig=" + rig, "and a second camera"},
      {"gst:a || b || c?rig=" + rig, "names 3 cameras"},
      {"gst:videotestsrc?layout=side-by-side&pair_within_ms=-1&rig=" + rig, "from 0 to 1000"},
      {"gst:videotestsrc?layout=side-by-side&rig=/nowhere.yaml", "/nowhere.yaml"},
      {"v4l2:/dev/video97?layout=side-by-side&rig=" + rig, "/dev/video97"},
      {"v4l2:/dev/video0?layout=side-by-side&size=640&rig=" + rig, "wants WIDTHxHEIGHT"},
      {"v4l2:/dev/video0?layout=side-by-side&rate=0&rig=" + rig, "frames a second"}};
  for (const auto& [source, says] : cases) {
    const auto stream = OpenLive(source);
    EXPECT_FALSE(stream.ok()) << source;
    EXPECT_THAT(std::string(stream.status().message()), HasSubstr(says)) << source;
    // Without the camera the same is known, but for what the device itself says.
    if (absl::StrContains(source, "/dev/video97")) continue;
    EXPECT_THAT(std::string(Check(source).message()), HasSubstr(says)) << source;
  }
}

TEST(GstSourceTest, ACheckPassesWhatCanStart) {
  EXPECT_TRUE(
      Check(absl::StrCat("gst:videotestsrc || videotestsrc?rig=", WriteRig(kSmallStereoRig))).ok());
}

// Users name their elements as they like.
TEST(GstSourceTest, AnElementMayBeCalledFirst) {
  const auto stream =
      OpenLive(absl::StrCat("gst:videotestsrc name=first num-buffers=2 ! "
                            "video/x-raw,width=320,height=120,framerate=20/1"
                            "?layout=side-by-side&rig=",
                            WriteRig(kSmallStereoRig)));
  EXPECT_TRUE(stream.ok()) << stream.status();
}

TEST(GstSourceTest, WhatIsNoDepthIsRefusedWithItsFormat) {
  const std::string colour = TestCamera(20);
  const std::string depth = Pictures("depth", {160, 120}, CV_16UC1);
  const std::string grey8 =
      "videotestsrc num-buffers=20 ! video/x-raw,format=GRAY8,width=160,"
      "height=120,framerate=20/1";
  const std::string rgb =
      "videotestsrc num-buffers=20 ! video/x-raw,format=RGB,width=160,"
      "height=120,framerate=20/1";
  for (const auto& [source, says] :
       {std::pair(depth + " || " + rgb, "RGB"), std::pair(colour + " || " + grey8, "GRAY8")}) {
    const auto stream = OpenLive(absl::StrCat("gst:", source, "?rig=", WriteRig(kRgbd)));
    ASSERT_TRUE(stream.ok()) << stream.status();
    const Played played = Play(**stream);
    EXPECT_THAT(played.frames, IsEmpty());
    EXPECT_THAT(std::string(played.end.message()),
                AllOf(HasSubstr("the depth pipeline gives video/x-raw"), HasSubstr(says),
                      HasSubstr("depth is GRAY16_LE")));
  }
}

// Ten bits of sixteen, as an infra-red camera gives them, are no black picture.
TEST(GstSourceTest, GreyOfTenBitsIsScaledAsARecordingsIs) {
  const Listener listener("grey-bits-assumed");
  const std::string folder = absl::StrCat(::testing::TempDir(), "/gst_ten");
  std::filesystem::create_directories(folder);
  cv::Mat picture(120, 320, CV_16UC1);
  for (int x = 0; x < 320; ++x) picture.col(x) = cv::Scalar(3 * x);
  for (int i = 0; i < 3; ++i) cv::imwrite(absl::StrCat(folder, "/", i, ".png"), picture);
  const auto stream =
      OpenLive(absl::StrCat("gst:multifilesrc location=", folder,
                            "/%d.png index=0 stop-index=2 caps=image/png,framerate=20/1 ! pngdec"
                            "?layout=side-by-side&rig=",
                            WriteRig(kSmallStereoRig)));
  ASSERT_TRUE(stream.ok()) << stream.status();
  const Played played = Play(**stream);
  ASSERT_GE(played.frames.size(), 1u);
  EXPECT_EQ(played.frames[0].images.grey.at<uint8_t>(5, 100), 300 / 4);
  EXPECT_EQ(played.frames[0].images.right.at<uint8_t>(5, 100), 780 / 4);
  EXPECT_EQ(listener.told(), 1);
}

TEST(GstSourceTest, BothHalvesOfOnePictureHaveItsTime) {
  const std::string rig = absl::StrReplaceAll(
      kSmallStereoRig,
      {{"principal_px: [80, 60]}\n  - ", "principal_px: [80, 60], time_offset_s: 0.012}\n  - "}});
  ASSERT_NE(rig, kSmallStereoRig);
  const auto stream = OpenLive(
      absl::StrCat("gst:", TestCamera(3, "", 320), "?layout=side-by-side&rig=", WriteRig(rig)));
  ASSERT_TRUE(stream.ok()) << stream.status();
  EXPECT_GE(Play(**stream).frames.size(), 1u);
  ASSERT_EQ((*stream)->findings().size(), 1u);
  EXPECT_EQ((*stream)->findings()[0].code, "time-offset-unused");
}

// Without identity sync=true ten minutes pass in a second.
TEST(GstSourceTest, APlaybackThatNobodyHoldsBackIsSaid) {
  const Listener listener("identity sync=true");
  const auto stream = OpenLive(absl::StrCat(
      "gst:", TestCamera(200, "", 320), "?layout=side-by-side&rig=", WriteRig(kSmallStereoRig)));
  ASSERT_TRUE(stream.ok()) << stream.status();
  EXPECT_TRUE(Play(**stream).end.ok());
  EXPECT_EQ(listener.told(), 1);
}

// The rig has the numbers of pictures of another size, as a recording's may.
TEST(GstSourceTest, AnImprobableRigMustBeTrusted) {
  const std::string askew = absl::StrReplaceAll(kSmallStereoRig, {{"[80, 60]", "[120, 60]"}});
  const std::string source =
      absl::StrCat("gst:", TestCamera(3, "", 320), "?layout=side-by-side&rig=", WriteRig(askew));
  EXPECT_THAT(std::string(OpenLive(source).status().message()),
              HasSubstr("cx 120 px of 160 can't be"));
  const auto trusted = OpenLive(source + "&trust-calibration=1");
  EXPECT_TRUE(trusted.ok()) << trusted.status();
}

TEST(GstSourceTest, ASpecIsWrittenBack) {
  RegisterGstSources();
  const auto spec = ParseSourceSpec(
      "gst:videotestsrc pattern=18 || videotestsrc?pair-within-ms=8&rig=/a.yaml&restart=1");
  ASSERT_TRUE(spec.ok()) << spec.status();
  const auto again = ParseSourceSpec(FormatSourceSpec(*spec));
  ASSERT_TRUE(again.ok()) << again.status() << FormatSourceSpec(*spec);
  EXPECT_EQ(FormatSourceSpec(*again), FormatSourceSpec(*spec));
  EXPECT_THAT(std::string(OpenReader(*spec).status().message()), HasSubstr("is a live camera"));
}

}  // namespace
}  // namespace corbslam::client_agent
