// A robot without a map store is killed (SIGKILL) while it maps, or its power goes: what its spool
// then has against the keyframes that it had made. A keyframe that is in the spool is there for
// good; one that is newer than all of them is lost, and may be a second old at most. When the power
// goes, the disk keeps what was synced, and any part of the rest; a kill keeps all that was
// written.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client_agent/spool/testing/unsynced_loss_files.h"
#include "client_agent/upload/held_back_items.h"
#include "client_agent/upload/spooled_map_reading.h"
#include "services/programs/spool_flags.h"
#include "tests/fault/fault_fixture.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using client_agent::CutPower;
using client_agent::PowerCutLoss;
using client_agent::ReadNewestSpooledMap;
using client_agent::SpooledMap;
using client_agent::TellHeldBack;
using services::OpenSpool;
using services::SpoolFlags;

namespace {

constexpr absl::Duration kMayBeLost = absl::Seconds(1);
constexpr absl::Duration kMayBeLostWhereBusy = absl::Seconds(10);
constexpr absl::Duration kLongestDrive = absl::Seconds(4);

struct MadeKeyframe {
  uint32_t index = 0;
  absl::Time made;
};

struct RobotKill {
  size_t made = 0;
  size_t lost = 0;
  size_t lost_too_old = 0;
  absl::Duration oldest_lost;
  PowerCutLoss disk;
};

void Add(const RobotKill& one, RobotKill& sum) {
  sum.made += one.made;
  sum.lost += one.lost;
  sum.lost_too_old += one.lost_too_old;
  sum.oldest_lost = std::max(sum.oldest_lost, one.oldest_lost);
  sum.disk.lost_bytes += one.disk.lost_bytes;
  sum.disk.came_back += one.disk.came_back;
}

class KilledRobotTest : public FaultTest {
 protected:
  SpoolFlags Spool(int kill) const {
    SpoolFlags flags;
    flags.folder = FileOf(absl::StrCat("spool", kill));
    return flags;
  }
  std::vector<MadeKeyframe> MadeBy(int kill) const {
    std::vector<MadeKeyframe> made;
    std::ifstream file(FileOf(absl::StrCat("keyframes", kill)));
    uint32_t index = 0;
    int64_t nanos = 0;
    while (file >> index >> nanos) made.push_back({index, absl::FromUnixNanos(nanos)});
    return made;
  }
  // The index after the newest keyframe that the spool has; 0: it has none.
  uint32_t NextInSpool(int kill) {
    auto spool = OpenSpool(Spool(kill), "mortal");
    EXPECT_TRUE(spool.ok()) << spool.status();
    if (!spool.ok()) return 0;
    const absl::Status told = TellHeldBack(**spool);
    EXPECT_TRUE(told.ok()) << told;
    const absl::StatusOr<SpooledMap> kept = ReadNewestSpooledMap(**spool);
    EXPECT_TRUE(kept.ok() || absl::IsNotFound(kept.status())) << kept.status();
    return kept.ok() ? kept->next_keyframe() : 0;
  }
  std::string LedgerOf(int kill) const { return FileOf(absl::StrCat("ledger", kill)); }
  // Starts the robot and returns once it has made a keyframe. Each other one has files so small
  // that some are removed.
  auto StartRobot(int kill) {
    std::vector<std::string> arguments = {
        "--source",    DemoSource(),       "--keyframes", FileOf(absl::StrCat("keyframes", kill)),
        "--spool",     Spool(kill).folder, "--resume",    "--ledger",
        LedgerOf(kill)};
    if (kill % 2 == 1) arguments.insert(arguments.end(), {"--segment-bytes", "200000"});
    auto robot = Start(absl::StrCat("robot", kill), "mortal_robot", arguments, /*security=*/{});
    EXPECT_NE(robot, nullptr);
    // It loads its vocabulary first.
    const absl::Time deadline = absl::Now() + absl::Seconds(30);
    while (MadeBy(kill).empty() && absl::Now() < deadline) absl::SleepFor(absl::Milliseconds(2));
    return robot;
  }
  // Compares what was made before `ended` with what the spool has, up to the index `next`.
  RobotKill Judge(int kill, uint32_t next, absl::Time ended) const {
    RobotKill result;
    for (const MadeKeyframe& keyframe : MadeBy(kill)) {
      ++result.made;
      if (keyframe.index < next) continue;
      ++result.lost;
      const absl::Duration age = ended - keyframe.made;
      result.oldest_lost = std::max(result.oldest_lost, age);
      result.lost_too_old += age > kMayBeLost ? 1 : 0;
    }
    return result;
  }
  RobotKill Kill(int kill, absl::Duration after) {
    auto robot = StartRobot(kill);
    absl::SleepFor(after);
    const absl::Time killed = absl::Now();
    robot.reset();
    const RobotKill result = Judge(kill, NextInSpool(kill), killed);
    std::filesystem::remove_all(Spool(kill).folder);
    return result;
  }
  RobotKill CutPowerOf(int cut, absl::Duration after, bool start_again, std::mt19937& random) {
    auto robot = StartRobot(cut);
    absl::SleepFor(after);
    const absl::Time went = absl::Now();
    robot.reset();
    const PowerCutLoss loss = CutPower(Spool(cut).folder, LedgerOf(cut), random);
    const uint32_t next = NextInSpool(cut);
    RobotKill result = Judge(cut, next, went);
    result.disk = loss;
    if (start_again && next > 0) {
      std::filesystem::remove(FileOf(absl::StrCat("keyframes", cut)));
      robot = StartRobot(cut);
      const std::vector<MadeKeyframe> made = MadeBy(cut);
      EXPECT_FALSE(made.empty()) << "it goes on";
      robot.reset();
    }
    std::filesystem::remove_all(Spool(cut).folder);
    return result;
  }
};

void WriteFigures(const RobotKill& sum, int kills, const char* path) {
  if (path == nullptr) return;
  const nlohmann::ordered_json figures = {
      {"kills", kills},
      {"keyframes_made", sum.made},
      {"keyframes_lost", sum.lost},
      {"keyframes_lost_older_than_a_second", sum.lost_too_old},
      {"oldest_lost_ms", absl::ToDoubleMilliseconds(sum.oldest_lost)},
      {"unsynced_bytes_lost", sum.disk.lost_bytes},
      {"removed_files_back", sum.disk.came_back}};
  std::ofstream(path) << figures.dump(2) << "\n";
}

void PrintHead() {
  std::printf(
      "| end | keyframes made | lost | lost, older than 1 s | oldest lost, ms | unsynced bytes "
      "lost "
      "| removed files back |\n| --- | --- | --- | --- | --- | --- | --- |\n");
}

void Print(int kill, const RobotKill& one) {
  std::printf("| %d | %zu | %zu | %zu | %.0f | %llu | %d |\n", kill, one.made, one.lost,
              one.lost_too_old, absl::ToDoubleMilliseconds(one.oldest_lost),
              static_cast<unsigned long long>(one.disk.lost_bytes), one.disk.came_back);
  std::fflush(stdout);
}

void ExpectLittleLost(const RobotKill& sum, bool is_long) {
  EXPECT_GT(sum.made, 0u);
  // A machine that builds beside it keeps no times.
  EXPECT_LT(sum.oldest_lost, kMayBeLostWhereBusy);
  if (!is_long) return;
  EXPECT_EQ(sum.lost_too_old, 0u) << "of " << sum.made << " keyframes";
}

// CORBSLAM_ROBOT_KILLS: how many, on a machine that does nothing else; CORBSLAM_ROBOT_KILLS_JSON: a
// file for the figures.
TEST_F(KilledRobotTest, LosesNoKeyframeThatIsASecondOld) {
  const int kills = CountFromEnvironment("CORBSLAM_ROBOT_KILLS", 2);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> share(0, 1);
  RobotKill sum;
  PrintHead();
  for (int kill = 0; kill < kills; ++kill) {
    const RobotKill one = Kill(kill, share(random) * kLongestDrive);
    Print(kill, one);
    Add(one, sum);
  }
  WriteFigures(sum, kills, std::getenv("CORBSLAM_ROBOT_KILLS_JSON"));
  ExpectLittleLost(sum, std::getenv("CORBSLAM_ROBOT_KILLS") != nullptr);
}

// CORBSLAM_ROBOT_POWER_CUTS and CORBSLAM_ROBOT_POWER_CUTS_JSON: likewise.
TEST_F(KilledRobotTest, ALossOfPowerTakesNoKeyframeThatIsASecondOld) {
  const int cuts = CountFromEnvironment("CORBSLAM_ROBOT_POWER_CUTS", 2);
  std::mt19937 random(12);
  std::uniform_real_distribution<double> share(0, 1);
  RobotKill sum;
  PrintHead();
  for (int cut = 0; cut < cuts; ++cut) {
    const absl::Duration after = share(random) * kLongestDrive;
    const RobotKill one = CutPowerOf(cut, after, /*start_again=*/cut % 20 == 1, random);
    Print(cut, one);
    Add(one, sum);
  }
  WriteFigures(sum, cuts, std::getenv("CORBSLAM_ROBOT_POWER_CUTS_JSON"));
  ExpectLittleLost(sum, std::getenv("CORBSLAM_ROBOT_POWER_CUTS") != nullptr);
}

}  // namespace
}  // namespace corbslam::tests
