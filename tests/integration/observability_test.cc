// Tests that what the running programs say of themselves is what happened: metrics and logs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <fstream>
#include <map>
#include <set>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "services/client/reflection/generic_client.h"
#include "services/client/remote/channel.h"
#include "services/http/testing/raw_http.h"
#include "tests/integration/mission_fixture.h"
#include "tests/integration/observed_mission.h"

namespace corbslam::tests {

using services::GenericClient;
using services::MakeChannel;

namespace {

using nlohmann::json;

constexpr char kStatistics[] = "corbslam.v1.MapStore/GetStatistics";
constexpr char kSync[] = "corbslam.v1.MapStore/Sync";
// gRPC puts so much before each message; robots count it.
constexpr double kFrameBytes = 5;

// protobuf's JSON has 64-bit numbers as text, and leaves out zeros.
double Number(const json& object, const std::string& field) {
  const json value = object.value(field, json(0));
  return value.is_string() ? std::stod(value.get<std::string>()) : value.get<double>();
}

class MetricsTest : public ObservedMissionTest {
 protected:
  json Statistics() { return Ask(kStatistics, {{"mission", "missions/lab"}})["mission"]; }

  void ExpectWhatTheStoreSays(const Scrape& store, const json& statistics) {
    const auto of_mission = [&store](const std::string& name) {
      return store.Value(name, {{"mission", "lab"}});
    };
    EXPECT_GT(of_mission("corbslam_mission_keyframes"), 4);
    EXPECT_EQ(of_mission("corbslam_mission_keyframes"), Number(statistics, "keyframes"));
    EXPECT_GE(of_mission("corbslam_mission_map_points"), Number(statistics, "mapPoints"));
    EXPECT_EQ(of_mission("corbslam_mission_islands"), 1);
    EXPECT_EQ(of_mission("corbslam_mission_local_maps"), 2);
    EXPECT_EQ(of_mission("corbslam_mission_agents_connected"), 2);
    EXPECT_EQ(of_mission("corbslam_mission_revision"), Number(statistics, "revision"));
    for (const char* stage : {"queried", "verified"}) {
      std::string field = absl::StrCat("overlaps", stage);
      field[8] = static_cast<char>(std::toupper(field[8]));
      EXPECT_EQ(store.Value("corbslam_mission_overlaps_total", {{"stage", stage}}),
                Number(statistics, field));
    }
    EXPECT_EQ(of_mission("corbslam_mission_overlaps_accepted"),
              Number(statistics, "overlapsAccepted"));
    EXPECT_EQ(store.Value("corbslam_merge_duration_seconds_count"), statistics["mergeMs"].size());
    double merge_s = 0;
    for (const json& ms : statistics["mergeMs"]) merge_s += ms.get<double>() * 1e-3;
    EXPECT_NEAR(store.Value("corbslam_merge_duration_seconds_sum"), merge_s, 1e-6);
    EXPECT_EQ(store.Value("corbslam_global_adjustment_duration_seconds_count"),
              statistics.value("adjustments", json::array()).size());
    EXPECT_EQ(store.Sum("corbslam_fusion_requests_waiting"), 0);
    EXPECT_EQ(store.Count("corbslam_fusion_requests_waiting"), 3u);
    EXPECT_EQ(store.Value("corbslam_journal_writable"), 1);
    EXPECT_EQ(store.Sum("corbslam_journal_errors_total"), 0);
    EXPECT_EQ(store.Value("corbslam_batches_waiting"), 0);
  }

  // Expects that both ends have counted the same bytes up and down.
  void ExpectBothEndsAgree(const Scrape& store, const std::vector<Scrape>& robots) {
    const auto of_robots = [&robots](const std::string& name) {
      double sum = 0;
      for (const Scrape& robot : robots) sum += robot.Sum(name);
      return sum;
    };
    const std::map<std::string, std::string> sync = {{"method", kSync}};
    EXPECT_EQ(of_robots("corbslam_robot_sent_bytes_total"),
              store.Sum("corbslam_agent_received_bytes_total") +
                  kFrameBytes * store.Value("corbslam_rpc_received_message_bytes_count", sync));
    EXPECT_EQ(of_robots("corbslam_robot_received_bytes_total"),
              store.Sum("corbslam_agent_sent_bytes_total") +
                  kFrameBytes * store.Value("corbslam_rpc_sent_message_bytes_count", sync));
    EXPECT_EQ(store.Value("corbslam_rpc_received_message_bytes_sum", sync),
              store.Sum("corbslam_agent_received_bytes_total"));
    EXPECT_EQ(of_robots("corbslam_robot_acknowledgement_duration_seconds_count"),
              store.Value("corbslam_batches_total", {{"code", "OK"}}));
    EXPECT_EQ(store.Value("corbslam_acknowledgement_duration_seconds_count"),
              store.Sum("corbslam_agent_batches_total"));
    EXPECT_EQ(store.Value("corbslam_rpc_calls_running", sync), 2) << "both robots stay";
  }

  void ExpectAWholeRun(const Scrape& robot) {
    EXPECT_EQ(robot.Sum("corbslam_robot_frames_total"), 86);
    EXPECT_GE(robot.Value("corbslam_robot_frames_total", {{"state", "tracking"}}), 84);
    EXPECT_EQ(robot.Value("corbslam_robot_frame_duration_seconds_count"), 86);
    EXPECT_EQ(robot.Sum("corbslam_robot_tracking_state"), 1) << "one state at a time";
    // A frame that became one after its result is counted with the next frame.
    EXPECT_GE(robot.Value("corbslam_robot_keyframes_made_total") + 1,
              robot.Value("corbslam_robot_keyframes"));
    EXPECT_GT(robot.Value("corbslam_robot_keyframes"), 1);
    EXPECT_EQ(robot.Sum("corbslam_robot_outbox_bytes"), 0) << "all is acknowledged";
    EXPECT_EQ(robot.Value("corbslam_robot_outbox_batches"), 0);
    EXPECT_EQ(robot.Count("corbslam_robot_held_back_items"), 4u);
    EXPECT_EQ(robot.Sum("corbslam_robot_held_back_items"), 0);
    EXPECT_EQ(robot.Sum("corbslam_robot_held_back_seconds"), 0);
    EXPECT_EQ(robot.Value("corbslam_robot_connected"), 1);
    EXPECT_EQ(robot.Value("corbslam_robot_reconnects_total"), 0);
    EXPECT_EQ(robot.Value("corbslam_robot_local_maps_lost_total"), 0);
    EXPECT_EQ(robot.Value("corbslam_robot_in_global_frame"), 1);
  }

  void WriteJson(const std::string& name, const json& content) {
    std::ofstream(FileOf(name)) << content.dump();
  }
};

TEST_F(MetricsTest, SayWhatHappened) {
  const json statistics = Statistics();
  // The state is asked for once, so that robots' calls are in their metrics, too.
  for (const char* name : {"alpha", "bravo"}) {
    GenericClient robot(MakeChannel(AddressOf(name)));
    ASSERT_TRUE(robot.Call("corbslam.v1.Agent/GetStatus", "{}").ok());
  }
  const Scrape store = ScrapeOf("store");
  const Scrape worker = ScrapeOf("worker");
  const std::vector<Scrape> robots = {ScrapeOf("alpha"), ScrapeOf("bravo")};
  ExpectWhatTheStoreSays(store, statistics);
  ExpectBothEndsAgree(store, robots);
  for (const Scrape& robot : robots) {
    ExpectAWholeRun(robot);
    EXPECT_EQ(robot.Value("corbslam_rpc_calls_total", {{"method", "corbslam.v1.Agent/GetStatus"}}),
              1);
  }
  EXPECT_EQ(robots[0].Value("corbslam_robot_info", {{"mission", "lab"}, {"agent", "alpha"}}), 1);
  for (const char* kind : {"verify", "fuse", "adjust"}) {
    const std::map<std::string, std::string> good = {{"kind", kind}, {"code", "OK"}};
    EXPECT_GE(worker.Value("corbslam_fusion_requests_total", good), 1) << kind;
    EXPECT_EQ(worker.Value("corbslam_fusion_requests_total", good),
              store.Value("corbslam_fusion_requests_total", good))
        << kind;
  }
  EXPECT_EQ(worker.Value("corbslam_worker_requests_held"), 0);
  EXPECT_EQ(worker.Value("corbslam_rpc_calls_total",
                         {{"method", "corbslam.v1.FusionWorker/FuseMaps"}, {"code", "OK"}}),
            worker.Value("corbslam_fusion_requests_total", {{"kind", "fuse"}, {"code", "OK"}}));
  WriteJson("store.json", store.families());
  WriteJson("worker.json", worker.families());
  WriteJson("alpha.json", robots[0].families());
  // The script fails where docs/metrics.md is not what was scraped.
  RunScript("check_metric_table.py", {absl::StrCat(CORBSLAM_SOURCE_DIR, "/docs/metrics.md"),
                                      absl::StrCat("map_store=", FileOf("store.json")),
                                      absl::StrCat("fusion_worker=", FileOf("worker.json")),
                                      absl::StrCat("client_agent=", FileOf("alpha.json"))});
}

TEST_F(MetricsTest, GoWithWhatTheyAreAbout) {
  EXPECT_EQ(ScrapeOf("store").Count("corbslam_agent_connected", {{"mission", "lab"}}), 2u);
  Ask("corbslam.v1.MapStore/DeleteMission", {{"name", "missions/lab"}});
  const Scrape store = ScrapeOf("store");
  EXPECT_EQ(store.Value("corbslam_missions"), 0);
  for (const auto& [name, family] : store.families().items()) {
    EXPECT_EQ(store.Count(name, {{"mission", "lab"}}), 0u) << name;
  }
  EXPECT_EQ(store.Value("corbslam_rpc_calls_total",
                        {{"method", "corbslam.v1.MapStore/DeleteMission"}, {"code", "OK"}}),
            1);
}

// Each of these requests ended a program once.
TEST_F(MetricsTest, AreAllThereIsAndNoRequestEndsAProgram) {
  for (const char* name : {"store", "worker", "alpha"}) {
    const std::string address = MetricsAddressOf(name);
    const auto status = [&address](const char* method, const char* path) {
      return testing::StatusOf(testing::Ask(address, testing::MakeRequest(method, path)));
    };
    EXPECT_EQ(status("GET", "/"), 404) << name;
    EXPECT_EQ(status("HEAD", "/"), 404) << name;
    EXPECT_EQ(status("GET", "/nowhere"), 404) << name;
    EXPECT_EQ(status("POST", "/metrics"), 405) << name;
    EXPECT_EQ(status("HEAD", "/metrics"), 200) << name;
    EXPECT_EQ(ScrapeOf(name).Count("corbslam_build_info"), 1u) << name;
  }
}

// Robots' programs sent none once, though every part of the way had a test.
TEST_F(ObservedMissionTest, TheStoreHasPicturesOfEachRobotsKeyframes) {
  const json list = Ask("corbslam.v1.MapStore/ListKeyframes",
                        {{"parent", "missions/lab/localMaps/-"}, {"page_size", 1000}});
  std::map<std::string, int> with_picture;
  for (const json& keyframe : list["keyframes"]) {
    const std::string name = keyframe["name"];
    const json seen = Ask("corbslam.v1.MapStore/GetKeyframe",
                          {{"name", name}, {"view", "KEYFRAME_VIEW_PICTURE"}});
    // What JPEGs begin with, in base 64.
    if (!absl::StartsWith(seen.value("picture", ""), "/9j/")) continue;
    ++with_picture[name.substr(0, name.find("/keyframes/"))];
  }
  EXPECT_EQ(with_picture.size(), 2u) << "local maps with pictures";
  for (const auto& [local_map, pictures] : with_picture) EXPECT_GT(pictures, 1) << local_map;
}

TEST_F(ObservedMissionTest, JsonLogsSayWhoseSessionItIs) {
  StopAll();
  std::set<std::string> opened;
  int objects = 0;
  for (const absl::string_view line : absl::StrSplit(ReadText(LogOf("store")), '\n')) {
    if (line.empty() || absl::StartsWith(line, "listening on ") ||
        absl::StartsWith(line, "metrics on ")) {
      continue;
    }
    const json object = json::parse(line.begin(), line.end(), nullptr, false);
    ASSERT_TRUE(object.is_object()) << line;
    for (const char* field : {"time", "severity", "file", "line", "message"}) {
      EXPECT_TRUE(object.contains(field)) << line;
    }
    ++objects;
    if (absl::StartsWith(object["message"].get<std::string>(), "session opened by ")) {
      EXPECT_EQ(object.value("mission", ""), "lab");
      opened.insert(object.value("agent", ""));
    }
  }
  EXPECT_GT(objects, 3);
  EXPECT_EQ(opened, (std::set<std::string>{"alpha", "bravo"}));
}

}  // namespace
}  // namespace corbslam::tests
