// Reads back what `corbslam mission show` and `mission export` write of a real mission.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "foxglove/point_cloud.pb.h"
#include "services/client/store/store_reader.h"
#include "services/tool/export/mcap/testing/mcap_reader.h"
#include "services/tool/export/testing/colmap_reader.h"
#include "slam/evaluation/trajectory_io.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using services::ConnectToStore;
using services::StoreReader;
using services::ToTrajectory;
using services::WithoutTls;

namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// Two robots' mission on a running store.
class ExportTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_FALSE(servers_.store_address().empty());
    RunMission({"--source", DemoSource(), "--robots", "2", "--server", servers_.store_address(),
                "--insecure", "--mission", "lab"});
    if (HasFailure()) return;
    auto channel = ConnectToStore(servers_.store_address(), WithoutTls());
    ASSERT_TRUE(channel.ok()) << channel.status();
    reader_ = std::make_unique<StoreReader>(*channel, "lab");
  }

  std::string Run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "mission");
    arguments.insert(arguments.end(), {"--server", servers_.store_address(), "--insecure"});
    return RunTool(arguments);
  }
  // The log's warning of --insecure comes first.
  nlohmann::json RunForJson(const std::vector<std::string>& arguments) {
    const std::string text = Run(arguments);
    const size_t begin = std::min(text.find_first_of("{["), text.size());
    return nlohmann::json::parse(text.substr(begin), nullptr, false);
  }
  // Returns where it was exported to.
  std::string Export(const std::string& format, std::vector<std::string> more = {}) {
    const std::string path = absl::StrCat(::testing::TempDir(), "/corbslam_export_test_", format);
    more.insert(more.begin(), {"export", "--mission", "lab", "--format", format, "--out", path});
    Run(more);
    return path;
  }
  Trajectory Served(const std::string& agent) {
    const auto served = reader_->ReadTrajectory(agent, v1::TRAJECTORY_FRAME_GLOBAL);
    EXPECT_TRUE(served.ok()) << served.status();
    return served.ok() ? ToTrajectory(*served) : Trajectory();
  }

  void CheckTrajectories();
  void CheckPoints();
  void CheckColmap();
  void CheckRecording();
  void CheckRecordingOnRobotsClock();
  void CheckShow();

  RunningServers servers_;
  std::unique_ptr<StoreReader> reader_;
};

void ExpectSame(const absl::StatusOr<Trajectory>& read, const Trajectory& served,
                bool times = true) {
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->size(), served.size());
  for (size_t i = 0; i < served.size(); ++i) {
    const Rigid3d& a = (*read)[i].world_from_camera;
    const Rigid3d& b = served[i].world_from_camera;
    ASSERT_LT((a.translation - b.translation).norm(), 1e-7);
    ASSERT_LT(a.rotation.angularDistance(b.rotation), 1e-6);
    ASSERT_TRUE(!times || (*read)[i].timestamp_ns == served[i].timestamp_ns);
  }
}

void ExportTest::CheckTrajectories() {
  const Trajectory alpha = Served("alpha");
  ASSERT_GT(alpha.size(), 50u);
  ExpectSame(ReadTumTrajectory(Export("tum", {"--agent", "alpha"})), alpha);
  const std::string kitti = Export("kitti", {"--agent", "alpha"});
  ExpectSame(ReadKittiTrajectory(kitti, kitti + ".times"), alpha);
  ExpectSame(ReadKittiTrajectory(kitti), alpha, /*times=*/false);
  ExpectSame(ReadEurocTrajectory(Export("euroc", {"--agent", "alpha"}), Rigid3d()), alpha);
  // Everybody's trajectories are exported into a folder.
  const std::string folder = ::testing::TempDir() + "/corbslam_export_test_all";
  Run({"export", "--mission", "lab", "--format", "euroc", "--out", folder});
  for (const char* name : {"alpha", "bravo"}) {
    ExpectSame(ReadEurocTrajectory(absl::StrCat(folder, "/", name, ".csv"), Rigid3d()),
               Served(name));
  }
}

void ExportTest::CheckPoints() {
  const auto map = reader_->ReadGlobalMap();
  ASSERT_TRUE(map.ok()) << map.status();
  const std::string text = ReadText(Export("ply"));
  EXPECT_THAT(text, AllOf(HasSubstr("comment robot alpha #"), HasSubstr("comment robot bravo #"),
                          HasSubstr(absl::StrCat("element vertex ", map->points.size(), "\n"))));
  EXPECT_EQ(text.size(), text.find("end_header\n") + 11 + 15 * map->points.size());
}

void ExportTest::CheckColmap() {
  const auto model = testing::ReadColmapModel(Export("colmap"));
  ASSERT_TRUE(model.ok()) << model.status();
  const auto map = reader_->ReadGlobalMap();
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(model->images.size(), map->keyframes.size());
  EXPECT_EQ(model->cameras.size(), 2u);
  EXPECT_GT(model->points.size(), 500u);
  const std::vector<double> errors_px = testing::ReprojectionErrors_px(*model);
  ASSERT_GT(errors_px.size(), 2 * model->points.size());
  // Half a pixel's shift between the conventions, forgotten once, is 0.7 px.
  EXPECT_LT(errors_px[errors_px.size() / 2], 1.2);
  EXPECT_LT(errors_px[errors_px.size() * 9 / 10], 4.0);
  size_t fused = 0;
  for (const auto& [id, point] : model->points) {
    std::set<int64_t> cameras;
    for (const auto& [image, keypoint] : point.track) {
      cameras.insert(model->images.at(image).camera);
    }
    fused += cameras.size() > 1 ? 1 : 0;
  }
  EXPECT_GT(fused, 20u) << "no landmarks that both robots see";
}

void ExportTest::CheckRecording() {
  const auto file = testing::ReadMcap(Export("mcap", {"--clock", "recording"}));
  ASSERT_TRUE(file.ok()) << file.status();
  const auto map = reader_->ReadMap();
  ASSERT_TRUE(map.ok()) << map.status();
  const auto frames = file->On("/frames");
  EXPECT_GT(frames.size(), 2u) << "moments of the past";
  size_t points = 0;
  for (const char* robot : {"alpha", "bravo"}) {
    EXPECT_EQ(file->On(absl::StrCat("/map/", robot, "/keyframes")).size(), frames.size());
    EXPECT_EQ(file->On(absl::StrCat("/robots/", robot, "/pose")).size(), Served(robot).size());
    for (const auto& message : file->On(absl::StrCat("/map/", robot, "/points"))) {
      foxglove::PointCloud cloud;
      ASSERT_TRUE(cloud.ParseFromString(message.data));
      EXPECT_EQ(message.time_ns, frames.back().time_ns);
      points += cloud.data().size() / cloud.point_stride();
    }
  }
  ASSERT_EQ(map->islands.size(), 1u);
  EXPECT_EQ(points, map->islands.begin()->second.points.size());
  std::string log;
  for (const auto& message : file->On("/log")) log += message.data;
  EXPECT_THAT(log, AllOf(HasSubstr("alpha joined"), HasSubstr("are one island"),
                         HasSubstr(": accepted, ")));
}

// So that it lies beside a bag of the robot's.
void ExportTest::CheckRecordingOnRobotsClock() {
  const auto file = testing::ReadMcap(Export("mcap"));
  ASSERT_TRUE(file.ok()) << file.status();
  for (const char* robot : {"alpha", "bravo"}) {
    const Trajectory served = Served(robot);
    const auto poses = file->On(absl::StrCat("/robots/", robot, "/pose"));
    ASSERT_EQ(poses.size(), served.size());
    for (size_t i = 0; i < poses.size(); ++i) {
      EXPECT_EQ(poses[i].time_ns, static_cast<uint64_t>(served[i].timestamp_ns));
    }
    EXPECT_GT(file->On(absl::StrCat("/map/", robot, "/points")).size(), 2u) << "as they came";
  }
}

void ExportTest::CheckShow() {
  EXPECT_THAT(Run({"show", "--mission", "lab"}),
              AllOf(HasSubstr("Mission lab: 2 robots, "), HasSubstr("alpha/1 and bravo/1, fused: "),
                    HasSubstr(" accepted (up to ")));
  const auto json = RunForJson({"show", "--mission", "lab", "--json"});
  ASSERT_FALSE(json.is_discarded());
  EXPECT_EQ(json["mission"]["agents"], 2);
  EXPECT_EQ(json["agents"][0]["name"], "missions/lab/agents/alpha");
  const auto list = RunForJson({"list", "--json"});
  ASSERT_FALSE(list.is_discarded());
  EXPECT_EQ(list[0]["name"], "missions/lab");
}

// All checks share one mission, which takes longer than what is read of it.
TEST_F(ExportTest, WhatIsWrittenIsWhatTheStoreHas) {
  ASSERT_NO_FATAL_FAILURE(CheckTrajectories());
  ASSERT_NO_FATAL_FAILURE(CheckPoints());
  ASSERT_NO_FATAL_FAILURE(CheckColmap());
  ASSERT_NO_FATAL_FAILURE(CheckRecording());
  ASSERT_NO_FATAL_FAILURE(CheckRecordingOnRobotsClock());
  ASSERT_NO_FATAL_FAILURE(CheckShow());
}

}  // namespace
}  // namespace corbslam::tests
