#include "tests/integration/mission_fixture.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"

namespace corbslam::tests {

using services::ChildProcess;

namespace {

namespace fs = std::filesystem;

// Makes an empty folder of this test alone.
std::string MakeFolder(const std::string& name) {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  const std::string leaf =
      absl::StrCat("corbslam_", test->test_suite_name(), "_", test->name(), "_", name);
  const fs::path folder = fs::path(::testing::TempDir()) / absl::StrReplaceAll(leaf, {{"/", "_"}});
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder.string();
}

}  // namespace

std::string DemoSource() {
  return absl::StrCat("tum:", CORBSLAM_SOURCE_DIR, "/tests/data/tum_fr1_xyz");
}

std::optional<std::string> RecordingsFolder() {
  const char* folder = std::getenv("CORBSLAM_DATA_DIR");
  return folder == nullptr ? std::nullopt : std::optional<std::string>(folder);
}

std::string RunTool(const std::vector<std::string>& arguments, int timeout_s) {
  std::vector<std::string> command = {absl::StrCat(CORBSLAM_PROGRAMS_DIR, "/corbslam")};
  command.insert(command.end(), arguments.begin(), arguments.end());
  const std::string log = MakeFolder("tool") + "/output.txt";
  const auto process = ChildProcess::Start("corbslam", command, log);
  EXPECT_TRUE(process.ok()) << process.status();
  if (!process.ok()) return "";
  EXPECT_TRUE((*process)->WaitForEnd(absl::Seconds(timeout_s))) << "still runs: " << ReadText(log);
  EXPECT_TRUE((*process)->EndStatus().ok()) << (*process)->EndStatus();
  return ReadText(log);
}

Mission RunMission(std::vector<std::string> arguments, const std::string& name, int timeout_s) {
  Mission mission;
  mission.folder = MakeFolder(name);
  arguments.insert(arguments.begin(), "run");
  arguments.insert(arguments.end(), {"--out", mission.folder});
  RunTool(arguments, timeout_s);
  mission.report = nlohmann::json::parse(ReadText(mission.folder + "/report.json"), nullptr, false);
  EXPECT_FALSE(mission.report.is_discarded()) << "no report.json";
  if (mission.report.is_discarded()) mission.report = nlohmann::json::object();
  return mission;
}

RunningServers::RunningServers() : log_folder_(MakeFolder("servers")) {
  const std::string worker = Start("fusion_worker", {});
  if (!worker.empty()) {
    store_address_ = Start(
        "map_store", {"--worker", worker, "--data-dir", absl::StrCat(log_folder_, "/missions")});
  }
}

RunningServers::~RunningServers() {
  // The store stops first, so that it does not miss its worker.
  for (auto server = servers_.rbegin(); server != servers_.rend(); ++server) {
    (*server)->Stop(absl::Seconds(10));
  }
}

std::string RunningServers::Start(const std::string& program, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), absl::StrCat(CORBSLAM_PROGRAMS_DIR, "/", program));
  arguments.insert(arguments.end(), {"--listen", "127.0.0.1:0", "--insecure"});
  auto server =
      ChildProcess::Start(program, arguments, absl::StrCat(log_folder_, "/", program, ".log"));
  EXPECT_TRUE(server.ok()) << server.status();
  if (!server.ok()) return "";
  servers_.push_back(std::move(*server));
  const auto address = servers_.back()->WaitForAddress(absl::Seconds(60));
  EXPECT_TRUE(address.ok()) << address.status();
  return address.value_or("");
}

bool RunningServers::Run() const {
  for (const auto& server : servers_) {
    if (server->end().has_value()) return false;
  }
  return servers_.size() == 2;
}

std::string ReadText(const std::string& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace corbslam::tests
