#include "client_agent/live/openni2/openni_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/time/clock.h"
#include "client_agent/source/frame_stream.h"
#include "client_agent/source/source_spec.h"

namespace corbslam::client_agent {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr char kRig[] =
    "rig: 1\nkind: rgbd\nrate_hz: 30\ncameras:\n"
    "  - {size_px: [160, 120], focal_px: [100, 100], principal_px: [80, 60]}\n"
    "depth:\n  units_per_m: 1000\n";
// The same eye as the colour camera's: what is registered stays where it is.
constexpr char kDepthCamera[] =
    "  camera: {size_px: [160, 120], focal_px: [100, 100], principal_px: [80, 60]}\n"
    "  colour_from_depth: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n";

// OpenNI loads the drivers beside its library once: the made-up one, and the system's for
// recordings.
class OpenNiSourceTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    setenv("CORBSLAM_MADE_UP_UNPLUGGED", Unplugged().c_str(), 1);
    fs::remove(Unplugged());
  }
  void SetUp() override { setenv("CORBSLAM_MADE_UP_REGISTERS", "0", 1); }

  static fs::path Unplugged() { return fs::path(::testing::TempDir()) / "openni_unplugged"; }

  static absl::StatusOr<std::unique_ptr<FrameStream>> Open(const std::string& place,
                                                           const std::string& rig,
                                                           const std::string& more = "") {
    RegisterOpenNiSources();
    const std::string path = ::testing::TempDir() + "/openni_rig.yaml";
    std::ofstream(path) << rig;
    const auto spec = ParseSourceSpec(absl::StrCat("openni2:", place, "?rig=", path, more));
    if (!spec.ok()) return spec.status();
    return spec->settings->OpenLive(absl::Notification());
  }

  // Takes up to `most` frames, for twenty seconds.
  static std::vector<StreamFrame> Take(FrameStream& stream, size_t most) {
    std::vector<StreamFrame> frames;
    const absl::Time end = absl::Now() + absl::Seconds(20);
    while (frames.size() < most && absl::Now() < end) {
      auto next = stream.Next(absl::Now() + absl::Milliseconds(100));
      EXPECT_TRUE(next.ok()) << next.status();
      if (!next.ok() || std::holds_alternative<StreamEnd>(*next)) break;
      if (auto* frame = std::get_if<StreamFrame>(&*next)) frames.push_back(std::move(*frame));
    }
    return frames;
  }

  static void ExpectUnmirrored(const SensorImages& images) {
    ASSERT_EQ(images.grey.type(), CV_8UC1);
    EXPECT_EQ(images.grey.at<uint8_t>(7, 20), 20);
    ASSERT_EQ(images.depth.type(), CV_16UC1);
    EXPECT_EQ(images.depth.at<uint16_t>(7, 20), 1020);
  }
};

TEST_F(OpenNiSourceTest, PlaysADevicesColourAndDepth) {
  const auto stream = Open("any", absl::StrCat(kRig, kDepthCamera));
  ASSERT_TRUE(stream.ok()) << stream.status();
  const auto frames = Take(**stream, 8);
  ASSERT_EQ(frames.size(), 8u);
  for (size_t i = 0; i < frames.size(); ++i) {
    ExpectUnmirrored(frames[i].images);
    if (i == 0) continue;
    // The device's own times: whole intervals apart, however late this program was.
    const int64_t step_ns = frames[i].frame.timestamp_ns - frames[i - 1].frame.timestamp_ns;
    EXPECT_EQ(step_ns % 33'333'000, 0) << step_ns;
    EXPECT_GT(step_ns, 0);
  }
}

TEST_F(OpenNiSourceTest, TheDeviceRegistersWhereItCan) {
  // The rig does not say how.
  EXPECT_THAT(std::string(Open("any", kRig).status().message()),
              HasSubstr("the device does not register depth to its picture"));
  EXPECT_TRUE(Open("any", kRig, "&register=0").ok()) << "as it comes";
  setenv("CORBSLAM_MADE_UP_REGISTERS", "1", 1);
  const auto stream = Open("made-up://0", kRig);
  ASSERT_TRUE(stream.ok()) << stream.status();
  ASSERT_EQ(Take(**stream, 1).size(), 1u);
}

TEST_F(OpenNiSourceTest, ADeviceThatWasUnpluggedIsWaitedFor) {
  const auto stream = Open("any", absl::StrCat(kRig, kDepthCamera));
  ASSERT_TRUE(stream.ok()) << stream.status();
  const auto before = Take(**stream, 3);
  ASSERT_EQ(before.size(), 3u);
  std::ofstream(Unplugged()) << "\n";
  absl::SleepFor(absl::Milliseconds(1500));
  ASSERT_TRUE((*stream)->Next(absl::Now()).ok());  // The newest that came before, if any.
  EXPECT_TRUE(std::holds_alternative<NoFrameYet>(*(*stream)->Next(absl::Now())));
  fs::remove(Unplugged());
  const auto after = Take(**stream, 3);
  ASSERT_EQ(after.size(), 3u);
  EXPECT_GT(after[0].frame.timestamp_ns - before[2].frame.timestamp_ns, 500'000'000);
}

TEST_F(OpenNiSourceTest, PlaysARecordingToItsEnd) {
  const std::string file = ::testing::TempDir() + "/made_up.oni";
  // By a program of its own: the recorder's thread ends, which OpenNI does not survive
  // (lasting_thread.h).
  const fs::path recorder =
      fs::read_symlink("/proc/self/exe").parent_path() / "client_agent_live_openni2_record_made_up";
  const std::string record =
      absl::StrCat(CORBSLAM_EMULATOR, " '", recorder.string(), "' '", file, "'");
  ASSERT_EQ(std::system(record.c_str()), 0);
  const auto stream = Open(file, absl::StrCat(kRig, kDepthCamera));
  ASSERT_TRUE(stream.ok()) << stream.status();
  const auto frames = Take(**stream, 1000);
  ASSERT_GE(frames.size(), 5u);
  // It was recorded mirrored.
  for (const StreamFrame& frame : frames) ExpectUnmirrored(frame.images);
  EXPECT_TRUE(std::holds_alternative<StreamEnd>(*(*stream)->Next(absl::Now())));
}

TEST_F(OpenNiSourceTest, ACheckKnowsTheRigsKindAndOptionsWithoutADevice) {
  const auto check = [](const std::string& rig, const std::string& more) {
    RegisterOpenNiSources();
    const std::string path = ::testing::TempDir() + "/openni_checked_rig.yaml";
    std::ofstream(path) << rig;
    return ParseSourceSpec(absl::StrCat("openni2:any?rig=", path, more))->settings->CheckLive();
  };
  EXPECT_TRUE(check(kRig, "").ok());
  EXPECT_THAT(std::string(check("rig: 1\nkind: stereo\nrectified: true\nbaseline_m: 0.1\ncameras:\n"
                                "  - {size_px: [160, 120], focal_px: [100, 100], principal_px: "
                                "[80, 60]}\n"
                                "  - {size_px: [160, 120], focal_px: [100, 100], principal_px: "
                                "[80, 60]}\n",
                                "")
                              .message()),
              HasSubstr("is of a stereo pair"));
  EXPECT_THAT(std::string(check(kRig, "&register=1").message()), HasSubstr("through which lens"));
}

TEST_F(OpenNiSourceTest, SaysWhatIsWrong) {
  const std::string with_camera = absl::StrCat(kRig, kDepthCamera);
  const struct {
    std::string place, from, to, says;
  } cases[] = {
      {"/nowhere.oni", "", "", "OpenNI 2 opens no /nowhere.oni"},
      {"any", "units_per_m: 1000", "units_per_m: 5000", "the rig says 5000"},
      {"any", "[160, 120], focal_px: [100, 100], principal_px: [80, 60]}\ndepth",
       "[320, 240], focal_px: [200, 200], principal_px: [160, 120]}\ndepth",
       "gives no colour of 320x240"},
  };
  for (const auto& [place, from, to, says] : cases) {
    const std::string rig =
        from.empty() ? with_camera : absl::StrReplaceAll(with_camera, {{from, to}});
    EXPECT_THAT(std::string(Open(place, rig).status().message()), HasSubstr(says));
  }
}

}  // namespace
}  // namespace corbslam::client_agent
