// Tests a robot that runs with what its mission's owner has signed, by the real programs.
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
#include "services/security/testing/token_keys.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {
namespace {

using nlohmann::json;
using services::ChildProcess;
using ::testing::AllOf;
using ::testing::HasSubstr;

class RobotSettingsTest : public ::testing::Test {
 protected:
  RobotSettingsTest() {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    const test_data::TokenKeys keys = test_data::MakeTokenKeys();
    std::ofstream(FileOf("owner.key")) << keys.private_pem;
    std::ofstream(FileOf("owner.pem")) << keys.public_pem;
    std::ofstream(FileOf("other.key")) << test_data::MakeTokenKeys().private_pem;
    RunTool({"mission", "create", "lab", "--insecure", "--server", servers_.store_address()});
  }
  std::string FileOf(const std::string& name) const { return absl::StrCat(folder_, "/", name); }

  void Set(const std::string& key, std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"mission", "settings", "lab", "--insecure", "--server",
                                 servers_.store_address(), "--sign", FileOf(key)});
    RunTool(flags);
  }
  // Runs alpha to its end, and returns its statistics.
  json Drive(const std::vector<std::string>& more) {
    std::vector<std::string> command = {absl::StrCat(CORBSLAM_PROGRAMS_DIR, "/client_agent"),
                                        "--insecure",
                                        "--server",
                                        servers_.store_address(),
                                        "--source",
                                        DemoSource(),
                                        "--frames",
                                        "0:30",
                                        "--mission",
                                        "lab",
                                        "--agent",
                                        "alpha",
                                        "--stats",
                                        FileOf("stats.json")};
    command.insert(command.end(), more.begin(), more.end());
    const auto robot = ChildProcess::Start("alpha", command, FileOf("log"));
    EXPECT_TRUE(robot.ok()) << robot.status();
    if (!robot.ok()) return {};
    EXPECT_TRUE((*robot)->WaitForEnd(absl::Minutes(3)));
    EXPECT_TRUE((*robot)->EndStatus().ok()) << (*robot)->EndStatus();
    return json::parse(ReadText(FileOf("stats.json")));
  }

  const std::string folder_ =
      absl::StrCat(::testing::TempDir(), "/corbslam_robot_settings_",
                   ::testing::UnitTest::GetInstance()->current_test_info()->name());
  RunningServers servers_;
};

TEST_F(RobotSettingsTest, ARobotRunsWithWhatItsOwnerSigned) {
  Set("owner.key", {"--features", "700", "--max-rate", "5"});
  Set("owner.key", {"--agent", "alpha", "--uplink-kbps", "100000"});
  const json stats = Drive({"--settings-key", FileOf("owner.pem"), "--settings-kept",
                            FileOf("kept"), "--features", "800"});
  const std::string taken = stats["settings"]["taken"].dump();
  EXPECT_THAT(taken, AllOf(HasSubstr("# features = 700"), HasSubstr("the flag was given and stays"),
                           HasSubstr("max-rate = 5"), HasSubstr("uplink-kbps = 100000")));
  EXPECT_TRUE(stats["settings"]["refused"].empty()) << stats["settings"].dump();
  // The camera made 15 frames a second, or more.
  EXPECT_GT(stats["dropped"].get<int>(), 5);
  EXPECT_GT(std::filesystem::file_size(FileOf("kept")), 64u);
}

TEST_F(RobotSettingsTest, WhatItsOwnerDidNotSignIsRefusedOrLeftOut) {
  Set("other.key", {"--max-rate", "1"});
  const json stats = Drive({"--settings-key", FileOf("owner.pem")});
  EXPECT_THAT(stats["settings"]["refused"].dump(),
              HasSubstr("of none of the keys that are trusted"));
  EXPECT_EQ(stats["dropped"], 0);
  const json without = Drive({});
  EXPECT_TRUE(without["settings"].is_null());
  EXPECT_THAT(ReadText(FileOf("log")), HasSubstr("--settings-key names no key"));
}

}  // namespace
}  // namespace corbslam::tests
