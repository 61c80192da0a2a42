// Tests two robots and one map, by the real programs on ports that the system chooses, on the
// recording that ships.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "services/client/reflection/generic_client.h"
#include "services/client/remote/channel.h"
#include "services/viewer/page_path.h"
#include "slam/evaluation/trajectory_error.h"
#include "slam/evaluation/trajectory_io.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using services::GenericClient;
using services::MakeChannel;

namespace {

using nlohmann::json;

// The demo's bound on the error is 3 cm.
constexpr double kMaxAte_m = 0.03;

void ExpectFields(const json& object, const std::vector<std::string>& fields) {
  for (const std::string& field : fields) EXPECT_TRUE(object.contains(field)) << field;
}

void ExpectWholeReport(const json& report) {
  ExpectFields(report, {"robots", "fused", "overlaps", "merge_ms", "global_ba_ms", "transfer",
                        "servers", "per_robot_minute", "wall_s", "version", "command"});
  for (const json& robot : report["robots"]) {
    ExpectFields(
        robot, {"name", "frames", "tracked", "dropped", "lost", "local_maps", "first_upload_s",
                "shared", "keyframes", "map_points", "ate_m", "t_rel_percent", "r_rel_deg_per_100m",
                "cpu_s", "tracking_ms", "local_ba_ms", "peak_rss_mb", "bytes_up", "bytes_down"});
    ExpectFields(robot["shared"], {"keyframes_held", "points_matched_percent", "loops_closed"});
    ExpectFields(robot["tracking_ms"], {"median", "mean", "p99"});
  }
  ExpectFields(report["fused"], {"islands", "robots", "keyframes", "map_points", "ate_m",
                                 "t_rel_percent", "r_rel_deg_per_100m"});
  ExpectFields(report["overlaps"], {"queried", "verified", "accepted"});
  ExpectFields(report["transfer"],
               {"full_keyframes", "full_map_points", "light_keyframes", "light_map_points"});
}

// Counts the rows of a file in TUM's format, without comments.
int CountPoses(const std::string& path) {
  const std::string text = ReadText(path);
  int poses = 0;
  for (const absl::string_view line : absl::StrSplit(text, '\n', absl::SkipEmpty())) {
    if (line.front() != '#') ++poses;
  }
  return poses;
}

// Expects the viewer's page in the report of a run whose store has no journal, where it was built.
void ExpectMapWithoutPast(const std::string& page) {
  if (!std::filesystem::exists(services::DefaultPagePath() + "/app.js")) return;
  EXPECT_THAT(page, ::testing::HasSubstr("<iframe"));
  EXPECT_THAT(page, ::testing::HasSubstr("&quot;hasPoints&quot;:true,&quot;hasPast&quot;:false,"));
}

TEST(MissionTest, TwoRobotsMakeOneMap) {
  const Mission mission = RunMission({"--source", DemoSource(), "--robots", "2"});
  const json& report = mission.report;
  ExpectWholeReport(report);
  ASSERT_EQ(report["robots"].size(), 2u);
  for (const json& robot : report["robots"]) {
    EXPECT_EQ(robot["frames"], 86);
    EXPECT_GE(robot["tracked"], 84);
    EXPECT_EQ(robot["dropped"], 0);
    EXPECT_LE(robot["ate_m"], kMaxAte_m);
    EXPECT_GT(robot["bytes_up"], 100'000);
    EXPECT_GT(robot["first_upload_s"], 0);
    EXPECT_GT(robot["peak_rss_mb"], 10);
    EXPECT_GT(robot["cpu_s"], 0.1);
    // The map came back.
    EXPECT_GT(robot["shared"]["keyframes_held"], 0) << robot["name"];
    const std::string name = robot["name"];
    EXPECT_EQ(CountPoses(absl::StrCat(mission.folder, "/", name, ".local.tum")), robot["tracked"]);
    EXPECT_EQ(CountPoses(absl::StrCat(mission.folder, "/", name, ".global.tum")), robot["tracked"]);
  }
  EXPECT_EQ(report["fused"]["islands"], 1);
  EXPECT_EQ(report["fused"]["robots"], 2);
  EXPECT_LE(report["fused"]["ate_m"], kMaxAte_m);
  EXPECT_GE(report["overlaps"]["accepted"], 1);
  EXPECT_GE(report["merge_ms"].size(), 1u);
  EXPECT_GE(report["global_ba_ms"].size(), 1u);
  // Each keyframe counts once, also those that a robot found redundant afterwards.
  const int kept =
      report["robots"][0]["keyframes"].get<int>() + report["robots"][1]["keyframes"].get<int>();
  EXPECT_GE(report["transfer"]["full_keyframes"]["count"], kept);
  EXPECT_LE(report["transfer"]["full_keyframes"]["count"], kept + 3);
  ExpectFields(report["servers"], {"map_store", "fusion_worker"});
  const json& cost = report["per_robot_minute"];
  EXPECT_GT(cost["pictures_s"], 0);
  EXPECT_GT(cost["robot_cpu_s"], 0);
  EXPECT_GT(cost["servers_cpu_s"]["map_store"], 0);
  EXPECT_GT(cost["servers_cpu_s"]["fusion_worker"], 0);
  EXPECT_GT(cost["global_adjustments"], 0);
  EXPECT_GT(std::filesystem::file_size(mission.folder + "/map.png"), 5'000u);
  EXPECT_THAT(ReadText(mission.folder + "/report.md"), ::testing::HasSubstr("| alpha |"));
  const std::string page = ReadText(mission.folder + "/report.html");
  for (const char* robot : {"alpha", "bravo"}) {
    EXPECT_THAT(page, ::testing::HasSubstr(absl::StrCat("<th scope=\"row\">", robot, "</th>")));
  }
  EXPECT_LT(page.size(), 10'000'000u);
  ExpectMapWithoutPast(page);
}

// Returns all poses in an answer, each by "agent nanoseconds".
std::map<std::string, Rigid3d> ReadPoses(const std::vector<std::string>& answers) {
  std::map<std::string, Rigid3d> poses;
  for (const std::string& answer : answers) {
    const json response = json::parse(answer);
    for (const json& pose : response["poses"]) {
      const json& rotation = pose["frameFromCamera"]["rotationWxyz"];
      const json& translation = pose["frameFromCamera"]["translation"];
      Rigid3d& global_from_camera = poses[absl::StrCat(pose["agent"].get<std::string>(), " ",
                                                       pose["timestampNs"].get<std::string>())];
      global_from_camera.rotation =
          Eigen::Quaterniond(rotation[0], rotation[1], rotation[2], rotation[3]);
      global_from_camera.translation =
          Eigen::Vector3d(translation[0], translation[1], translation[2]);
    }
  }
  return poses;
}

double Ate_m(const std::map<std::string, Rigid3d>& poses) {
  const auto truth = ReadTumTrajectory(DemoSource().substr(4) + "/groundtruth.txt");
  EXPECT_TRUE(truth.ok()) << truth.status();
  if (!truth.ok()) return 1e9;
  Trajectory estimate;
  for (const auto& [key, pose] : poses) {
    estimate.push_back({std::stoll(key.substr(key.find(' ') + 1)), pose});
  }
  const auto error = ComputeAbsoluteError(AssociateByTime(estimate, *truth), Alignment::kSe3);
  EXPECT_TRUE(error.ok()) << error.status();
  return error.ok() ? error->rmse_m : 1e9;
}

// The servers outlive the tool and the agents. A client that knows no more than the store's address
// learns from its reflection how to ask, and gets every robot's poses in the one global frame.
TEST(MissionTest, ARunningStoreTellsAGenericClientWhereTheRobotsAre) {
  RunningServers servers;
  ASSERT_FALSE(servers.store_address().empty());
  const Mission mission = RunMission({"--source", DemoSource(), "--server", servers.store_address(),
                                      "--insecure", "--mission", "asked"});
  ASSERT_TRUE(servers.Run());
  GenericClient client(MakeChannel(servers.store_address()));
  const auto services = client.ListServices();
  ASSERT_TRUE(services.ok()) << services.status();
  EXPECT_THAT(*services, ::testing::Contains("corbslam.v1.MapStore"));
  const auto answers =
      client.Call("corbslam.v1.MapStore/GetTrajectory",
                  R"({"name": "missions/asked/agents/-", "frame": "TRAJECTORY_FRAME_GLOBAL"})");
  ASSERT_TRUE(answers.ok()) << answers.status();
  const auto poses = ReadPoses(*answers);
  size_t tracked = 0;
  for (const json& robot : mission.report["robots"]) {
    tracked += robot["tracked"].get<size_t>();
    const std::string name = robot["name"];
    const auto written = ReadTumTrajectory(absl::StrCat(mission.folder, "/", name, ".global.tum"));
    ASSERT_TRUE(written.ok()) << written.status();
    for (const StampedPose& expected : *written) {
      const auto served =
          poses.find(absl::StrCat("missions/asked/agents/", name, " ", expected.timestamp_ns));
      ASSERT_NE(served, poses.end()) << name << " at " << expected.timestamp_ns << " ns";
      const Rigid3d difference = served->second.Inverse() * expected.world_from_camera;
      EXPECT_LT(difference.translation.norm(), 1e-5);
      EXPECT_LT(difference.rotation.angularDistance(Eigen::Quaterniond::Identity()), 1e-5);
    }
  }
  EXPECT_EQ(poses.size(), tracked);
  EXPECT_LE(Ate_m(poses), kMaxAte_m);
}

TEST(MissionTest, EvaluationOfTheFilesAgreesWithTheReport) {
  const Mission mission = RunMission({"--source", DemoSource(), "--pace", "step"});
  const std::string table = mission.folder + "/eval.json";
  RunTool({"eval", "--truth", DemoSource(), mission.folder + "/alpha.global.tum",
           mission.folder + "/bravo.global.tum", "--json", table});
  const json rows = json::parse(ReadText(table), nullptr, false);
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[2]["name"], "fused");
  EXPECT_NEAR(rows[2]["ate_m"], mission.report["fused"]["ate_m"], 1e-5);
  EXPECT_NEAR(rows[0]["ate_m"], mission.report["robots"][0]["ate_global_m"], 1e-5);
}

// What a batch holds beside its keyframes and points (frames, links, its head) is not counted.
TEST(MissionTest, LockstepCountsTheBytesThatWouldBeSent) {
  const Mission mission = RunMission({"--source", DemoSource(), "--pace", "step"});
  ASSERT_FALSE(mission.report.is_null());
  double items = 0;
  for (const auto& [name, counted] : mission.report["transfer"].items()) {
    items += counted["bytes"].get<double>();
  }
  double sent = 0;
  for (const auto& robot : mission.report["robots"]) sent += robot["bytes_up"].get<double>();
  EXPECT_LE(items, sent);
  EXPECT_GE(items, 0.7 * sent);
}

TEST(MissionTest, LockstepRepeatsToTheBit) {
  const std::vector<std::string> arguments = {"--source", DemoSource(), "--pace", "step"};
  const Mission first = RunMission(arguments, "first");
  const Mission second = RunMission(arguments, "second");
  EXPECT_EQ(first.report["fused"]["islands"], 1);
  EXPECT_LE(first.report["fused"]["ate_m"], kMaxAte_m);
  for (const char* file :
       {"alpha.local.tum", "alpha.global.tum", "bravo.local.tum", "bravo.global.tum", "map.png"}) {
    const std::string text = ReadText(absl::StrCat(first.folder, "/", file));
    EXPECT_FALSE(text.empty()) << file;
    EXPECT_EQ(text, ReadText(absl::StrCat(second.folder, "/", file))) << file;
  }
}

TEST(MissionTest, TheSecondRobotTracksAgainstTheFirstOnesMap) {
  const Mission mission = RunMission({"--source", DemoSource(), "--pace", "step", "--sequential"});
  EXPECT_EQ(mission.report["fused"]["islands"], 1);
  const json& second = mission.report["robots"][1];
  EXPECT_GT(second["shared"]["keyframes_held"], 0);
  EXPECT_GE(second["shared"]["points_matched_percent"], 10);
}

TEST(MissionTest, FindsItsPlaceInOtherPictures) {
  const Mission mission = RunMission(
      {"--source", DemoSource(), "--pace", "step", "--perturb", "2:gamma=0.8,noise=4,reverse"});
  EXPECT_EQ(mission.report["fused"]["islands"], 1);
  EXPECT_LE(mission.report["fused"]["ate_m"], 1.3 * kMaxAte_m);
}

}  // namespace
}  // namespace corbslam::tests
