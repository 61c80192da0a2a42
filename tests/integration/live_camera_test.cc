// Runs the robot's own program on a camera that a feeder plays in real time, through GStreamer: at
// sensor rate, disturbed, unplugged, and with pictures that show nothing for a while.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "services/runtime/child_process.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {
namespace {

using nlohmann::json;
using services::ChildProcess;
using ::testing::HasSubstr;

// A pair that is not rectified: the right camera is turned by a degree and has other intrinsics.
constexpr char kRig[] = R"(rig: 1
kind: stereo
cameras:
  - size_px: [512, 288]
    focal_px: [300, 301]
    principal_px: [257, 142]
    lens: radial-tangential
    lens_numbers: [-0.2, 0.04, 0.0002, -0.0001]
  - size_px: [512, 288]
    focal_px: [303, 302]
    principal_px: [251, 147]
    lens: radial-tangential
    lens_numbers: [-0.21, 0.05, 0.0001, 0.0002]
rectified: false
right_from_left: [0.99984770, -0.01745241, 0, -0.5,
                  0.01745241, 0.99984770, 0, -0.002,
                  0, 0, 1, 0,
                  0, 0, 0, 1]
rate_hz: 10
)";

struct LiveRun {
  json report = json::object();
  std::string robot_log;
  std::string feeder_log;
  int exit_code = -1;
};

class LiveCameraTest : public ::testing::Test {
 protected:
  LiveCameraTest()
      : folder_(::testing::TempDir() + "/live_camera_" +
                ::testing::UnitTest::GetInstance()->current_test_info()->name()) {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ + "/rig.yaml") << kRig;
  }

  // Plays so many frames of a drive, with more options of the simulation and of the feeder. A robot
  // that waits for its camera to come back is stopped when the feeder has ended.
  LiveRun Play(int frames, const std::string& options, std::vector<std::string> feeder_options,
               bool restarts = false) {
    LiveRun run;
    std::vector<std::string> feeder = {
        Program("camera_feeder"), "--source",
        absl::StrCat("sim:city?seed=3&length=100&threads=2&rig=", folder_,
                     "/rig.yaml&frames=0:", frames - 1, options)};
    feeder.insert(feeder.end(), feeder_options.begin(), feeder_options.end());
    const auto camera = ChildProcess::Start("camera", feeder, folder_ + "/feeder.log");
    EXPECT_TRUE(camera.ok()) << camera.status();
    if (!camera.ok()) return run;
    const auto address = (*camera)->WaitForAddress(absl::Seconds(120));
    EXPECT_TRUE(address.ok()) << address.status();
    if (!address.ok()) return run;
    const std::string port = address->substr(address->rfind(':') + 1);
    const auto robot = ChildProcess::Start(
        "robot",
        {Program("client_agent"), "--source",
         absl::StrCat("gst:tcpclientsrc host=127.0.0.1 port=", port,
                      " ! matroskademux?layout=side-by-side", restarts ? "&restart=1" : ""),
         "--rig", folder_ + "/rig.yaml", "--pace", "sensor", "--stats", folder_ + "/stats.json"},
        folder_ + "/robot.log");
    EXPECT_TRUE(robot.ok()) << robot.status();
    if (!robot.ok()) return run;
    EXPECT_TRUE((*camera)->WaitForEnd(absl::Seconds(120))) << "the feeder does not end";
    if (restarts) {
      run.exit_code = (*robot)->Stop(absl::Seconds(30)).exit_code;
    } else {
      EXPECT_TRUE((*robot)->WaitForEnd(absl::Seconds(60))) << "the robot does not end";
      run.exit_code = (*robot)->Stop(absl::Seconds(10)).exit_code;
    }
    run.robot_log = ReadText(folder_ + "/robot.log");
    run.feeder_log = ReadText(folder_ + "/feeder.log");
    run.report = json::parse(ReadText(folder_ + "/stats.json"), nullptr, false);
    EXPECT_TRUE(run.report.is_object()) << run.robot_log;
    if (!run.report.is_object()) run.report = json::object();
    return run;
  }

  static std::string Program(const std::string& name) {
    return absl::StrCat(CORBSLAM_PROGRAMS_DIR, "/", name);
  }

 private:
  const std::string folder_;
};

int Number(const LiveRun& run, const char* field) {
  EXPECT_TRUE(run.report.contains(field) && run.report[field].is_number_integer()) << field;
  return run.report.value(field, -1);
}

void ExpectOneMapThatEndsWell(const LiveRun& run) {
  EXPECT_EQ(run.exit_code, 0) << run.robot_log;
  EXPECT_EQ(Number(run, "local_maps"), 1) << run.robot_log;
  EXPECT_GT(run.report["latency_ms"].value("median", 0.0), 0);
  EXPECT_GE(run.report["latency_ms"].value("median", 0.0),
            run.report["tracking_ms"].value("median", 1e9));
}

// A busy machine makes a robot drop frames; those that it takes, it tracks.
TEST_F(LiveCameraTest, FramesAtSensorRateAreTracked) {
  const LiveRun run = Play(60, "", {});
  ExpectOneMapThatEndsWell(run);
  EXPECT_THAT(run.feeder_log, HasSubstr("fed 60 frames, of them 0 late and 0 doubled"));
  EXPECT_GE(Number(run, "frames"), 57);
  EXPECT_LE(Number(run, "frames"), 60);
  EXPECT_LE(Number(run, "lost"), 3);
  EXPECT_EQ(Number(run, "left_out"), 0);
  EXPECT_EQ(Number(run, "tracked") + Number(run, "lost") + Number(run, "dropped"),
            Number(run, "frames"));
}

TEST_F(LiveCameraTest, DroppedLateAndDoubledFramesAreSurvived) {
  const LiveRun run = Play(60, "", {"--drop", "0.1", "--late", "0.15", "--double", "0.1"});
  ExpectOneMapThatEndsWell(run);
  EXPECT_THAT(run.feeder_log, Not(HasSubstr(" 0 late")));
  EXPECT_GE(Number(run, "frames"), 45);
  EXPECT_LE(Number(run, "lost"), 3);
  // A frame that comes twice has its time twice in each of its halves, and is taken once.
  EXPECT_GE(Number(run, "left_out"), 2);
  EXPECT_EQ(Number(run, "left_out") % 2, 0);
}

// Ten seconds without a camera, then it shows the same place: the robot goes on in its map.
TEST_F(LiveCameraTest, ACameraThatWasUnpluggedIsWaitedFor) {
  const LiveRun run =
      Play(60, "", {"--unplug-at", "3.05", "--unplug", "10", "--hold"}, /*restarts=*/true);
  EXPECT_THAT(run.feeder_log, HasSubstr("plugged in again"));
  EXPECT_THAT(run.robot_log, HasSubstr("the camera went away"));
  EXPECT_THAT(run.robot_log, HasSubstr("the camera is back"));
  ExpectOneMapThatEndsWell(run);
  EXPECT_GE(Number(run, "tracked"), 40);
}

// Black, then blurred, then still: the robot begins where it can, and once.
TEST_F(LiveCameraTest, ADarkBeginningIsWaitedOut) {
  const LiveRun run = Play(70, "&beginning=1.5:1.5:1", {});
  ExpectOneMapThatEndsWell(run);
  // 15 black frames, at most 15 blurred ones, then 40.
  constexpr int kGoodFrames = 40;
  constexpr int kAfterTheFirst = 10;
  EXPECT_GE(Number(run, "tracked") + Number(run, "dropped"), kGoodFrames - kAfterTheFirst);
  EXPECT_LE(Number(run, "tracked"), 55);
}

TEST_F(LiveCameraTest, ExposureThatJumpsEndsNoMap) {
  const LiveRun run = Play(60, "&exposure_steps=2:0.3/3:1/4:2.2/5:1", {});
  ExpectOneMapThatEndsWell(run);
  EXPECT_LE(Number(run, "lost"), 5);
}

// The hand hides everything for 0.4 s and takes 0.6 s to come and go.
TEST_F(LiveCameraTest, AHandBeforeTheLensEndsNoMap) {
  const LiveRun run = Play(60, "&hand=3:1", {});
  ExpectOneMapThatEndsWell(run);
  EXPECT_LE(Number(run, "lost"), 15);
}

}  // namespace
}  // namespace corbslam::tests
