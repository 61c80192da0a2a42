// Kills a real map store again and again while robots stream to it.
#include <gtest/gtest.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/client/remote/channel.h"
#include "services/client/store/store_reader.h"
#include "services/runtime/child_process.h"
#include "tests/fault/fault_fixture.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using services::ChildProcess;
using services::ConnectToStore;
using services::StoreReader;
using services::WithoutTls;

namespace {

using nlohmann::json;

constexpr char kMission[] = "killed";

// Returns the largest number of kills; in the long form there are as many as fit while the robots
// drive.
int KillsWanted() { return WantsLongFaults() ? 1000 : 6; }

class KilledStoreTest : public FaultTest {
 protected:
  // Starts the store on the address of the one before it, if there was one.
  void StartStore() {
    const std::string listen = address_.empty() ? "127.0.0.1:0" : address_;
    const std::string name = absl::StrCat("store", starts_++);
    store_ = Start(name, "map_store",
                   {"--listen", listen, "--worker", worker_address_, "--data-dir", FileOf("data"),
                    "--keep-everything"});
    address_ = AddressOf(store_.get());
    ASSERT_NE(address_, "");
  }

  void StartAgent(const std::string& name, const std::string& options) {
    const std::string source = WantsLongFaults() ? LongSource() : DemoSource();
    agents_.emplace_back(name, Start(name, "client_agent",
                                     {"--source", absl::StrCat(source, "?", options), "--server",
                                      address_, "--mission", kMission, "--agent", name, "--pace",
                                      "sensor", "--stats", StatisticsOf(name)}));
  }
  std::string StatisticsOf(const std::string& name) const { return FileOf(name + ".json"); }

  bool AllFinished() const {
    for (const auto& [name, process] : agents_) {
      if (!process->end().has_value()) return false;
    }
    return true;
  }

  std::unique_ptr<ChildProcess> worker_;
  std::string worker_address_;
  std::unique_ptr<ChildProcess> store_;
  std::string address_;
  int starts_ = 0;
  std::vector<std::pair<std::string, std::unique_ptr<ChildProcess>>> agents_;
};

TEST_F(KilledStoreTest, EveryKeyframeIsThereOnce) {
  worker_ = Start("worker", "fusion_worker", {"--listen", "127.0.0.1:0"});
  worker_address_ = AddressOf(worker_.get());
  ASSERT_NE(worker_address_, "");
  StartStore();
  StartAgent("alpha", "robot=1/2");
  StartAgent("bravo", "robot=2/2");
  StartAgent("charlie", "robot=1/2&reverse=1");
  StartAgent("delta", "robot=2/2&reverse=1");

  std::mt19937 random(1);
  int kills = 0;
  while (kills < KillsWanted() && !AllFinished()) {
    absl::SleepFor(absl::Milliseconds(std::uniform_int_distribution<int>(100, 1500)(random)));
    store_->Stop(absl::ZeroDuration());  // SIGKILL.
    ++kills;
    StartStore();
  }
  EXPECT_GE(kills, 3) << "the robots were too fast for the test";
  std::printf("%d kills\n", kills);
  for (const auto& [name, process] : agents_) {
    ASSERT_TRUE(process->WaitForEnd(absl::Seconds(180))) << name;
    EXPECT_TRUE(process->EndStatus().ok()) << process->EndStatus();
  }

  const auto channel = ConnectToStore(address_, WithoutTls());
  ASSERT_TRUE(channel.ok()) << channel.status();
  StoreReader reader(*channel, kMission);
  ASSERT_TRUE(reader.WaitUntilFused(absl::Seconds(300)).ok());
  uint64_t keyframes = 0;
  const auto frames = reader.CountReportedFrames();
  ASSERT_TRUE(frames.ok()) << frames.status();
  for (const auto& [name, process] : agents_) {
    const json own = ReadStatistics(StatisticsOf(name));
    ASSERT_TRUE(own.is_object()) << name;
    keyframes += own["keyframes"].get<uint64_t>();
    // Each frame counts once: more were applied twice, fewer were lost.
    EXPECT_EQ(frames->at(name), own["tracked"].get<uint64_t>() + own["lost"].get<uint64_t>())
        << name;
  }
  const auto statistics = reader.Statistics();
  ASSERT_TRUE(statistics.ok()) << statistics.status();
  EXPECT_EQ(statistics->mission().keyframes(), keyframes);
}

}  // namespace
}  // namespace corbslam::tests
