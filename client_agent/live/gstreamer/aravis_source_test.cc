// Plays aravis' own fake camera, where aravis is installed.
#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "client_agent/live/gstreamer/device_pipelines.h"
#include "client_agent/live/gstreamer/gst_source.h"
#include "client_agent/live/gstreamer/testing/open_live.h"
#include "client_agent/source/frame_stream.h"
#include "client_agent/source/source_spec.h"

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;
using testing::kSmallStereoRig;
using testing::OpenLive;

std::string StereoRig() {
  const std::string path = ::testing::TempDir() + "/aravis_rig.yaml";
  std::ofstream(path) << kSmallStereoRig;
  return path;
}

// The camera that aravis has for tests is in the same process, and off until it is asked for.
// Returns whether it is here.
bool EnableFakeCamera() {
  RegisterGstSources();
  if (!IsGstSourceHere("aravis")) return false;
  void* const aravis = dlopen("libaravis-0.8.so.0", RTLD_NOW | RTLD_GLOBAL);
  if (aravis == nullptr) return false;
  void* const enable = dlsym(aravis, "arv_enable_interface");
  if (enable == nullptr) return false;
  reinterpret_cast<void (*)(const char*)>(enable)("Fake");
  return true;
}

std::vector<StreamFrame> Play(FrameStream& stream, size_t most) {
  std::vector<StreamFrame> frames;
  const absl::Time deadline = absl::Now() + absl::Seconds(20);
  while (absl::Now() < deadline && frames.size() < most) {
    auto next = stream.Next(absl::Now() + absl::Milliseconds(100));
    EXPECT_TRUE(next.ok()) << next.status();
    if (!next.ok() || std::holds_alternative<StreamEnd>(*next)) break;
    if (auto* frame = std::get_if<StreamFrame>(&*next)) frames.push_back(std::move(*frame));
  }
  return frames;
}

TEST(AravisSourceTest, PlaysACameraWithTheDevicesTimes) {
  if (!EnableFakeCamera()) GTEST_SKIP() << "aravis is not installed (libaravis-0.8-0)";
  // Its Mono16, and the colours of its filter where the plugin for them is here, come as grey.
  for (const std::string format : {"", "&format=GRAY16_LE"}) {
    const auto stream = OpenLive(absl::StrCat(
        "aravis:Fake_1?layout=side-by-side&size=320x120&rate=25&rig=", StereoRig(), format));
    ASSERT_TRUE(stream.ok()) << stream.status();
    const std::vector<StreamFrame> frames = Play(**stream, 5);
    ASSERT_EQ(frames.size(), 5u) << format;
    for (size_t i = 0; i < frames.size(); ++i) {
      const SensorImages& images = frames[i].images;
      ASSERT_EQ(images.grey.size(), cv::Size(160, 120));
      EXPECT_EQ(images.grey.type(), CV_8UC1);
      EXPECT_EQ(images.right.size(), images.grey.size());
      double least = 0;
      double most = 0;
      cv::minMaxLoc(images.grey, &least, &most);
      EXPECT_GT(most - least, 100) << "a gradient";
      if (i == 0) continue;
      // The fake camera stamps its pictures 40 ms apart, whenever they come.
      const double step_ms =
          1e-6 * static_cast<double>(images.timestamp_ns - frames[i - 1].images.timestamp_ns);
      EXPECT_GT(step_ms, 10);
    }
  }
}

TEST(AravisSourceTest, ACameraThatIsNotThereIsSaid) {
  if (!EnableFakeCamera()) GTEST_SKIP() << "aravis is not installed (libaravis-0.8-0)";
  const auto stream = OpenLive("aravis:Nobody?layout=side-by-side&rig=" + StereoRig());
  EXPECT_THAT(std::string(stream.status().message()), HasSubstr("Nobody"));
}

TEST(AravisSourceTest, WithoutThePluginItsPackageIsNamed) {
  RegisterGstSources();
  if (IsGstSourceHere("aravis")) GTEST_SKIP() << "aravis is installed";
  const auto stream = OpenLive("aravis:any?layout=side-by-side&rig=" + StereoRig());
  EXPECT_THAT(std::string(stream.status().message()), HasSubstr("libaravis-0.8-0"));
}

TEST(AravisSourceTest, SaysWhatIsWrong) {
  RegisterGstSources();
  const struct {
    std::string options, says;
  } cases[] = {{"aravis:A?rig=" + StereoRig(), "name a second camera"},
               {"aravis:A,A?rig=x", "names the same camera twice"},
               {"aravis:A,B,C?rig=x", "names 3 cameras"},
               {"aravis:A?layout=side-by-side&format=YUY2", "wants GRAY8"},
               {"aravis:A?layout=side-by-side&size=x", "wants WIDTHxHEIGHT"},
               {"aravis:A?layout=side-by-side&rate=30.5", "frames a second"},
               {"aravis:A?layout=side-by-side", "a live camera needs its rig"}};
  for (const auto& [options, says] : cases) {
    const auto stream = OpenLive(options);
    EXPECT_FALSE(stream.ok()) << options;
    EXPECT_THAT(std::string(stream.status().message()), HasSubstr(says)) << options;
  }
}

TEST(DevicePipelinesTest, AreWrittenForGStreamer) {
  EXPECT_EQ(
      V4l2Pipeline("/dev/video2", {"mjpeg", "1280x480", "30"}),
      "v4l2src device=/dev/video2 ! image/jpeg,width=1280,height=480,framerate=30/1 ! jpegdec");
  EXPECT_EQ(V4l2Pipeline("/dev/video0", {}), "v4l2src device=/dev/video0 ! video/x-raw");
  EXPECT_EQ(AravisPipeline("any", {}, false), "aravissrc ! video/x-raw,format=GRAY8");
  EXPECT_EQ(AravisPipeline("Maker \"A\"-12", {"rggb", "", "20"}, true),
            "aravissrc camera-name=\"Maker \\\"A\\\"-12\" do-timestamp=true ! "
            "video/x-bayer,format=rggb,framerate=20/1 ! bayer2rgb");
}

}  // namespace
}  // namespace corbslam::client_agent
