// Tests a robot that only localises, in a town that another one has mapped.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "services/runtime/child_process.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {
namespace {

using nlohmann::json;
using services::ChildProcess;
using ::testing::HasSubstr;

// The way goes round one block, in two fifths of the cameras' resolution.
constexpr char kBlock[] = "sim:city?seed=3&length=100&picture_scale=0.4&frames=";
// Half a frame later, in other light, with other noise.
constexpr char kOtherwise[] = "&phase=0.5&exposure=0.85&noise_seed=2";

class LocaliseOnlyTest : public ::testing::Test {
 protected:
  LocaliseOnlyTest() {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }

  // Runs a robot to its end, and returns how that was.
  absl::Status Drive(const std::string& name, const std::string& source,
                     const std::vector<std::string>& more = {}) {
    std::vector<std::string> command = {absl::StrCat(CORBSLAM_PROGRAMS_DIR, "/simulated_agent"),
                                        "--insecure",
                                        "--server",
                                        servers_.store_address(),
                                        "--source",
                                        source,
                                        "--agent",
                                        name,
                                        "--pace",
                                        "sensor",
                                        "--stats",
                                        FileOf(name + ".json"),
                                        "--trajectory",
                                        FileOf(name + ".tum")};
    command.insert(command.end(), more.begin(), more.end());
    auto robot = ChildProcess::Start(name, command, FileOf(name + ".log"));
    if (!robot.ok()) return robot.status();
    if (!(*robot)->WaitForEnd(absl::Minutes(5))) return absl::DeadlineExceededError("it runs on");
    return (*robot)->EndStatus();
  }
  json StatsOf(const std::string& name) { return json::parse(ReadText(FileOf(name + ".json"))); }
  json Mission() {
    const std::string said = RunTool({"mission", "show", "--insecure", "--json", "--mission",
                                      "default", "--server", servers_.store_address()});
    // Warnings of the log come first.
    return json::parse(said.substr(said.find('{')));
  }
  // Writes the trajectory that the store has of a robot; returns the number of its poses.
  int Export(const std::string& robot, const std::string& file) {
    RunTool({"mission", "export", "--insecure", "--mission", "default", "--server",
             servers_.store_address(), "--format", "tum", "--agent", robot, "--out", FileOf(file)});
    const std::vector<std::string> lines = absl::StrSplit(ReadText(FileOf(file)), '\n');
    return static_cast<int>(std::ranges::count_if(
        lines, [](const std::string& line) { return !line.empty() && line.front() != '#'; }));
  }
  // Returns the root mean square error of one robot's trajectory, or of all under one alignment.
  double ErrorOf(const std::vector<std::string>& names) {
    std::vector<std::string> command = {
        "eval",      "--truth", absl::StrCat(kBlock, ":110"), "--json", FileOf("errors.json"),
        "--max-gap", "0.06"};
    for (const std::string& name : names) command.push_back(FileOf(name + ".tum"));
    RunTool(command);
    const json errors = json::parse(ReadText(FileOf("errors.json")));
    return errors.back()["ate_m"].get<double>();
  }
  std::string FileOf(const std::string& name) const { return folder_ + "/" + name; }

  const std::string folder_ =
      absl::StrCat(::testing::TempDir(), "/corbslam_localise_only_",
                   ::testing::UnitTest::GetInstance()->current_test_info()->name());
  RunningServers servers_;
};

TEST_F(LocaliseOnlyTest, ItIsTrackedInOthersMapAndChangesNothing) {
  const absl::Status mapped = Drive("mapper", absl::StrCat(kBlock, ":110"));
  ASSERT_TRUE(mapped.ok()) << mapped;
  const json before = Mission();
  const absl::Status driven =
      Drive("guest", absl::StrCat(kBlock, "5:100", kOtherwise), {"--localise-only"});
  ASSERT_TRUE(driven.ok()) << driven;
  const json stats = StatsOf("guest");
  EXPECT_GE(stats["tracked"].get<int>(), 0.9 * (stats["frames"].get<int>())) << stats.dump(1);
  EXPECT_EQ(stats["keyframes"], 0);
  EXPECT_EQ(stats["map_points"], 0);
  EXPECT_GE(stats["shared"]["points_matched_percent"], 99);
  // The mapper's frame is the global one, so that both lie under one alignment.
  EXPECT_LE(ErrorOf({"guest"}), 0.3);
  EXPECT_LE(ErrorOf({"mapper", "guest"}), 0.3);
  const json after = Mission();
  EXPECT_EQ(after["local_maps"], before["local_maps"]);
  EXPECT_EQ(after["mission"]["keyframes"], before["mission"]["keyframes"]);
  EXPECT_EQ(after["mission"]["map_points"], before["mission"]["map_points"]);
  // The store has its trajectory now, as it lies in the map.
  EXPECT_EQ(Export("guest", "kept.tum"), stats["tracked"].get<int>());
  EXPECT_LE(ErrorOf({"kept"}), 0.3);
  EXPECT_LE(ErrorOf({"mapper", "kept"}), 0.3);
}

TEST_F(LocaliseOnlyTest, ItSaysThatItIsLostWhereNobodyHasBeen) {
  const absl::Status mapped = Drive("mapper", absl::StrCat(kBlock, ":30"));
  ASSERT_TRUE(mapped.ok()) << mapped;
  const absl::Status driven = Drive(
      "guest", "sim:city?seed=8&length=100&picture_scale=0.4&frames=:40", {"--localise-only"});
  EXPECT_THAT(std::string(driven.message()), HasSubstr("nothing"));
  const json stats = StatsOf("guest");
  EXPECT_EQ(stats["tracked"], 0) << stats.dump(1);
  EXPECT_EQ(stats["shared"]["places_told"], 0);
}

TEST_F(LocaliseOnlyTest, ItRefusesWhatWouldMakeNoSense) {
  EXPECT_THAT(std::string(Drive("guest", absl::StrCat(kBlock, ":9"),
                                {"--localise-only", "--share", "corrections"})
                              .message()),
              HasSubstr("--localise-only needs others' keyframes"));
  EXPECT_THAT(std::string(Drive("guest", absl::StrCat(kBlock, ":9"),
                                {"--localise-only", "--spool-dir", folder_})
                              .message()),
              HasSubstr("--spool-dir"));
}

}  // namespace
}  // namespace corbslam::tests
