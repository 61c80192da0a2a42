// Runs the examples of docs/clients, as docs/clients.md says, against a store with a small mission
// and a robot.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "services/runtime/child_process.h"
#include "services/security/testing/test_certificates.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using services::ChildProcess;

namespace {

namespace fs = std::filesystem;
using test_data::TestCertificates;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;

constexpr absl::Duration kStart = absl::Seconds(60);
constexpr absl::Duration kEnd = absl::Minutes(4);
// Of the camera that took the demo's pictures (docs/sources.md).
// Without its lens it is another camera, by which places are found or not.
constexpr char kCamera[] =
    "517.306408 516.469215 318.643040 255.313989 0.262383 -0.953104 -0.005358 0.002628 1.163314";

struct Ended {
  int exit_code = -1;
  std::string text;  // Of both outputs.
};

// One mission for all tests of the file; each test starts it anew, in some seconds.
class ClientsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }

  std::unique_ptr<ChildProcess> Start(const std::string& name, std::vector<std::string> command) {
    auto process = ChildProcess::Start(name, command, absl::StrCat(folder_, "/", name, ".log"));
    EXPECT_TRUE(process.ok()) << process.status();
    return process.ok() ? *std::move(process) : nullptr;
  }
  Ended RunToEnd(const std::string& name, const std::vector<std::string>& command) {
    const auto process = Start(name, command);
    if (process == nullptr) return {};
    EXPECT_TRUE(process->WaitForEnd(kEnd)) << name << " still runs";
    const int exit_code = process->Stop(absl::ZeroDuration()).exit_code;
    return {exit_code, ReadText(absl::StrCat(folder_, "/", name, ".log"))};
  }

  std::string StartServer(const std::string& name, std::vector<std::string> command) {
    command.front() = absl::StrCat(CORBSLAM_PROGRAMS_DIR, "/", command.front());
    processes_.push_back(Start(name, std::move(command)));
    if (processes_.back() == nullptr) return "";
    const auto address = processes_.back()->WaitForAddress(kStart);
    EXPECT_TRUE(address.ok()) << address.status();
    return address.value_or("");
  }

  // Starts a worker, a store with TLS, and a robot that has ended its way and stays.
  void StartMission() {
    const std::string worker = StartServer(
        "worker",
        With(certificates_.Flags("worker"), {"fusion_worker", "--listen", "127.0.0.1:0"}));
    store_ = StartServer("store", With(certificates_.Flags("store"),
                                       {"map_store", "--listen", "127.0.0.1:0", "--worker", worker,
                                        "--token-key", certificates_.Path("token.pub")}));
    robot_ =
        StartServer("alpha", With(certificates_.Flags("alpha"),
                                  {"client_agent", "--source", DemoSource(), "--frames", "0:40",
                                   "--server", store_, "--mission", "lab", "--agent", "alpha",
                                   "--stay", "--listen", "127.0.0.1:0", "--listen-insecure"}));
    ASSERT_FALSE(robot_.empty());
    ASSERT_TRUE(processes_.back()->WaitUntilFinished(kEnd));
  }

  static std::vector<std::string> With(const std::vector<std::string>& more,
                                       std::vector<std::string> command) {
    command.insert(command.end(), more.begin(), more.end());
    return command;
  }

  // Asks all that the examples can ask; `client` runs one of them.
  void ExpectAnswers(const std::vector<std::string>& client) {
    const std::vector<std::string> by_certificate = {"--ca",   certificates_.Path("ca.pem"),
                                                     "--cert", certificates_.Path("operator.pem"),
                                                     "--key",  certificates_.Path("operator.key")};
    const std::string token = certificates_.Path("eve.token");
    RunTool({"token", "--key", certificates_.Path("token.key"), "--mission", "lab", "--role",
             "viewer", "--name", "eve", "--lifetime", "1h", "--out", token});
    const std::vector<std::string> by_token = {"--ca", certificates_.Path("ca.pem"), "--token",
                                               token};
    const auto ask = [&](const std::vector<std::string>& arguments,
                         const std::vector<std::string>& identity) {
      return RunToEnd("client", With(identity, With(arguments, client)));
    };
    const Ended missions = ask({store_}, by_certificate);
    EXPECT_EQ(missions.exit_code, 0) << missions.text;
    EXPECT_THAT(missions.text, ContainsRegex("missions/lab: [1-9][0-9]* keyframes, 1 islands"));
    const Ended map = ask({store_, "--mission", "lab", "--messages", "1"}, by_token);
    EXPECT_EQ(map.exit_code, 0) << map.text;
    EXPECT_THAT(map.text, ContainsRegex("version [0-9]+: [1-9][0-9]* keyframes came or moved"));
    const Ended found =
        ask({store_, "--mission", "lab", "--picture", PictureOfTheMiddle(), "--camera", kCamera},
            by_token);
    EXPECT_EQ(found.exit_code, 0) << found.text;
    EXPECT_THAT(found.text, HasSubstr("LOCATE_STAGE_LOCATED"));
    const Ended events = ask({store_, "--mission", "lab", "--events", "--messages", "2"}, by_token);
    EXPECT_EQ(events.exit_code, 0) << events.text;
    EXPECT_THAT(events.text, AllOf(HasSubstr("agent_joined"), HasSubstr("local_map_begun")));
    const Ended changes = ask({robot_, "--pose", "--events", "--messages", "1"}, {});
    EXPECT_EQ(changes.exit_code, 0) << changes.text;
    EXPECT_THAT(changes.text, HasSubstr("AGENT_EVENT_KIND_LOCAL_MAP_BEGUN"));
    const Ended pose = ask({robot_, "--pose", "--messages", "1"}, {});
    EXPECT_EQ(pose.exit_code, 0) << pose.text;
    EXPECT_THAT(pose.text, HasSubstr("TRACKING_STATE_TRACKING"));
    const Ended unknown = ask({store_, "--mission", "nowhere"}, by_certificate);
    EXPECT_EQ(unknown.exit_code, 1);
    EXPECT_THAT(unknown.text, HasSubstr("NOT_FOUND: there is no mission nowhere"));
    const Ended dropped = ask({store_}, {"--token", token});
    EXPECT_EQ(dropped.exit_code, 1);
    EXPECT_THAT(dropped.text, HasSubstr("without --ca there is no TLS"));
    const Ended keyless = ask({store_}, {"--ca", certificates_.Path("ca.pem"), "--cert",
                                         certificates_.Path("operator.pem")});
    EXPECT_EQ(keyless.exit_code, 1);
    EXPECT_THAT(keyless.text, HasSubstr("a certificate needs its key"));
    const Ended stranger = ask({store_}, {"--ca", certificates_.Path("ca.pem")});
    EXPECT_EQ(stranger.exit_code, 1);
    EXPECT_THAT(stranger.text, HasSubstr("UNAUTHENTICATED"));
  }

  // Returns a picture from the middle of what the robot saw.
  static std::string PictureOfTheMiddle() {
    std::vector<std::string> pictures;
    for (const auto& file :
         fs::directory_iterator(absl::StrCat(CORBSLAM_SOURCE_DIR, "/tests/data/tum_fr1_xyz/rgb"))) {
      pictures.push_back(file.path());
    }
    std::sort(pictures.begin(), pictures.end());
    return pictures.at(20);
  }

  static std::string Example(const std::string& path) {
    return absl::StrCat(CORBSLAM_SOURCE_DIR, "/docs/clients/", path);
  }

  const std::string folder_ = ::testing::TempDir() + "/corbslam_clients";
  const TestCertificates certificates_{"lab"};
  std::vector<std::unique_ptr<ChildProcess>> processes_;
  std::string store_;
  std::string robot_;
};

#define SKIP_OR_FAIL(reason)                         \
  do {                                               \
    ASSERT_EQ(std::getenv("CI"), nullptr) << reason; \
    GTEST_SKIP() << reason;                          \
  } while (false)

TEST_F(ClientsTest, ThePythonExampleAnswers) {
  const std::string python = CORBSLAM_PYTHON;
  if (python.empty() || RunToEnd("look", {python, "-c", "import grpc"}).exit_code != 0) {
    SKIP_OR_FAIL("there is no python3-grpcio (deploy/packages_checks.txt)");
  }
  for (const char* file : {"client.py", "corbslam_link.py", "corbslam_link_test.py"}) {
    fs::copy_file(Example(absl::StrCat("python/", file)), absl::StrCat(folder_, "/", file));
  }
  const std::string proto = absl::StrCat(CORBSLAM_SOURCE_DIR, "/proto");
  std::vector<std::string> protoc = {
      CORBSLAM_PROTOC, "-I",
      proto,           "--python_out",
      folder_,         "--grpc_python_out",
      folder_,         "--plugin=protoc-gen-grpc_python=" CORBSLAM_GRPC_PYTHON};
  for (const auto& file : fs::directory_iterator(proto + "/corbslam/v1")) {
    protoc.push_back(file.path());
  }
  const Ended made = RunToEnd("protoc", protoc);
  ASSERT_EQ(made.exit_code, 0) << made.text;
  const Ended link = RunToEnd("link", {python, folder_ + "/corbslam_link_test.py"});
  EXPECT_EQ(link.exit_code, 0) << link.text;
  ASSERT_NO_FATAL_FAILURE(StartMission());
  ExpectAnswers({python, folder_ + "/client.py"});
}

TEST_F(ClientsTest, TheNodeExampleAnswers) {
  const std::string node = CORBSLAM_NODE;
  const std::string npm = CORBSLAM_NPM;
  if (node.empty() || npm.empty()) {
    SKIP_OR_FAIL("there is no node with npm (deploy/packages_page.txt)");
  }
  for (const char* file : {"client.mjs", "corbslam_link.mjs", "corbslam_link.test.mjs",
                           "package.json", "package-lock.json"}) {
    fs::copy_file(Example(absl::StrCat("node/", file)), absl::StrCat(folder_, "/", file));
  }
  const Ended installed = RunToEnd(
      "npm", {npm, "ci", "--prefix", folder_, "--no-audit", "--no-fund", "--ignore-scripts"});
  // As for the viewer's page, a registry that can't be reached is no fault of ours.
  if (installed.exit_code != 0) GTEST_SKIP() << "npm ci: " << installed.text;
  const Ended link = RunToEnd("link", {node, "--test", folder_ + "/corbslam_link.test.mjs"});
  EXPECT_EQ(link.exit_code, 0) << link.text;
  ASSERT_NO_FATAL_FAILURE(StartMission());
  ExpectAnswers(
      {node, folder_ + "/client.mjs", "--proto", absl::StrCat(CORBSLAM_SOURCE_DIR, "/proto")});
}

}  // namespace
}  // namespace corbslam::tests
