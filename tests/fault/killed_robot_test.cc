// A robot without a map store is killed (SIGKILL) while it maps: what its spool then has against
// the keyframes that it had made. A keyframe that is in the spool is there for good; one that is
// newer than all of them is lost, and may be a second old at most.
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
#include "client_agent/upload/held_items.h"
#include "client_agent/upload/kept_map_reading.h"
#include "services/programs/spool_flags.h"
#include "tests/fault/fault_fixture.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using client_agent::KeptMap;
using client_agent::ReadNewestKeptMap;
using client_agent::TellHeld;
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
};

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
    const absl::Status told = TellHeld(**spool);
    EXPECT_TRUE(told.ok()) << told;
    const absl::StatusOr<KeptMap> kept = ReadNewestKeptMap(**spool);
    EXPECT_TRUE(kept.ok() || absl::IsNotFound(kept.status())) << kept.status();
    return kept.ok() ? kept->next_keyframe() : 0;
  }
  RobotKill Kill(int kill, absl::Duration after) {
    auto robot =
        Start(absl::StrCat("robot", kill), "mortal_robot",
              {"--source", DemoSource(), "--keyframes", FileOf(absl::StrCat("keyframes", kill)),
               "--spool", Spool(kill).folder, "--resume"},
              /*security=*/{});
    EXPECT_NE(robot, nullptr);
    if (robot == nullptr) return {};
    // It loads its vocabulary first.
    const absl::Time deadline = absl::Now() + absl::Seconds(30);
    while (MadeBy(kill).empty() && absl::Now() < deadline) absl::SleepFor(absl::Milliseconds(2));
    absl::SleepFor(after);
    const absl::Time killed = absl::Now();
    robot.reset();
    RobotKill result;
    const uint32_t next = NextInSpool(kill);
    for (const MadeKeyframe& keyframe : MadeBy(kill)) {
      ++result.made;
      if (keyframe.index < next) continue;
      ++result.lost;
      const absl::Duration age = killed - keyframe.made;
      result.oldest_lost = std::max(result.oldest_lost, age);
      result.lost_too_old += age > kMayBeLost ? 1 : 0;
    }
    std::filesystem::remove_all(Spool(kill).folder);
    return result;
  }
};

void WriteFigures(const RobotKill& sum, int kills) {
  const char* path = std::getenv("CORBSLAM_ROBOT_KILLS_JSON");
  if (path == nullptr) return;
  const nlohmann::ordered_json figures = {
      {"kills", kills},
      {"keyframes_made", sum.made},
      {"keyframes_lost", sum.lost},
      {"keyframes_lost_older_than_a_second", sum.lost_too_old},
      {"oldest_lost_ms", absl::ToDoubleMilliseconds(sum.oldest_lost)}};
  std::ofstream(path) << figures.dump(2) << "\n";
}

// CORBSLAM_ROBOT_KILLS: how many, on a machine that does nothing else; CORBSLAM_ROBOT_KILLS_JSON: a
// file for the figures.
TEST_F(KilledRobotTest, LosesNoKeyframeThatIsASecondOld) {
  const int kills = CountFromEnvironment("CORBSLAM_ROBOT_KILLS", 2);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> share(0, 1);
  RobotKill sum;
  std::printf(
      "| kill | keyframes made | lost | lost, older than 1 s | oldest lost, ms |\n"
      "| --- | --- | --- | --- | --- |\n");
  for (int kill = 0; kill < kills; ++kill) {
    const RobotKill one = Kill(kill, share(random) * kLongestDrive);
    std::printf("| %d | %zu | %zu | %zu | %.0f |\n", kill, one.made, one.lost, one.lost_too_old,
                absl::ToDoubleMilliseconds(one.oldest_lost));
    sum.made += one.made;
    sum.lost += one.lost;
    sum.lost_too_old += one.lost_too_old;
    sum.oldest_lost = std::max(sum.oldest_lost, one.oldest_lost);
  }
  WriteFigures(sum, kills);
  EXPECT_GT(sum.made, 0u);
  // A machine that builds beside it keeps no times.
  EXPECT_LT(sum.oldest_lost, kMayBeLostWhereBusy);
  if (std::getenv("CORBSLAM_ROBOT_KILLS") == nullptr) return;
  EXPECT_EQ(sum.lost_too_old, 0u) << "of " << sum.made << " keyframes";
}

}  // namespace
}  // namespace corbslam::tests
