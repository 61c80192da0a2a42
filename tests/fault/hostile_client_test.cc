// Tests a map store that robots stream to while somebody attacks it: nothing of theirs is touched,
// its memory stays bounded, and they are acknowledged as before.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "map_store/testing/store_dump.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/remote_uplink.h"
#include "services/runtime/child_process.h"
#include "tests/fault/replay_fixture.h"
#include "tests/integration/mission_fixture.h"
#include "tests/replay/quantile.h"
#include "tests/replay/recorded_uploads.h"
#include "tests/replay/replaying_agent.h"

namespace corbslam::tests {

using services::ChildProcess;
using services::MakeChannel;
using services::MakeRemoteUplink;
using services::ProcessEnd;

namespace {

constexpr char kMission[] = "m";
constexpr size_t kVictims = 4;
constexpr uint64_t kFirstLocalMap = 0x1000;
constexpr double kKeyframesPerS = 7;

using Delay = ReplayLedger::Delay;

std::vector<double> InMs(const std::vector<Delay>& delays) {
  std::vector<double> ms;
  for (const Delay& delay : delays) ms.push_back(delay.ms());
  return ms;
}

// CORBSLAM_HOSTILE_MESSAGES: how many mutated ones; there are a tenth as many calls of each flood.
int MessagesWanted() { return CountFromEnvironment("CORBSLAM_HOSTILE_MESSAGES", 3000); }

class HostileClientTest : public ReplayFaultTest {
 protected:
  // Robots come from one host, the attacker from another, because a host may have only so many
  // streams.
  void StartStore(const std::string& name) {
    store_ = Start(name, "map_store",
                   {"--listen", "[::]:0", "--data-dir", FileOf(name), "--open-timeout", "3",
                    "--metrics-listen", "127.0.0.1:0"});
    const std::string address = AddressOf(store_.get());
    ASSERT_NE(address, "");
    port_ = address.substr(address.rfind(':'));
    metrics_ = MetricsAddressOf(name);
  }

  std::vector<std::unique_ptr<ReplayingAgent>> StartVictims(int laps) const {
    std::vector<std::unique_ptr<ReplayingAgent>> agents;
    for (size_t i = 0; i < kVictims; ++i) {
      const ReplayOptions options{.mission = kMission,
                                  .agent = absl::StrCat("agent", i),
                                  .local_map = LocalMapId{kFirstLocalMap * (i + 1)},
                                  .laps = laps,
                                  .keyframes_per_s = kKeyframesPerS};
      agents.push_back(std::make_unique<ReplayingAgent>(
          options, &uploads_, MakeRemoteUplink(MakeChannel("[::1]" + port_))));
    }
    return agents;
  }

  std::vector<Delay> WaitFor(const std::vector<std::unique_ptr<ReplayingAgent>>& agents) const {
    std::vector<Delay> delays;
    for (const auto& agent : agents) {
      const absl::Status done = agent->WaitUntilDone(absl::Minutes(30));
      EXPECT_TRUE(done.ok()) << done;
      const ReplayLedger ledger = agent->ledger();
      EXPECT_EQ(ledger.sessions, 1) << "it was thrown out";
      delays.insert(delays.end(), ledger.delays.begin(), ledger.delays.end());
    }
    return delays;
  }

  // Runs all attacks (attacker_main.cc), one after the other, while the robots stream. Returns what
  // the attacker wrote of them.
  nlohmann::json Attack(int messages) {
    const auto attacker = Start("attacker", "attacker",
                                {"127.0.0.1" + port_, kMission, "--metrics", metrics_, "--victim",
                                 absl::StrCat(kFirstLocalMap), "--source", DemoSource(),
                                 "--messages", absl::StrCat(messages), "--calls",
                                 absl::StrCat(messages / 10), "--out", FileOf("attacks.json")},
                                {});
    if (attacker == nullptr) return {};
    EXPECT_TRUE(attacker->WaitForEnd(absl::Minutes(30)));
    EXPECT_TRUE(attacker->EndStatus().ok()) << attacker->EndStatus();
    return ReadStatistics(FileOf("attacks.json"));
  }

  // A local map belongs to whoever sends its first batch.
  static void WaitUntilStreaming(const std::vector<std::unique_ptr<ReplayingAgent>>& victims) {
    for (const auto& victim : victims) {
      for (int i = 0; i < 600 && victim->ledger().acknowledged == 0; ++i) {
        absl::SleepFor(absl::Milliseconds(10));
      }
      ASSERT_GT(victim->ledger().acknowledged, 0u);
    }
  }

  // A robot of the same mission that keeps to all limits (dear_attacker_main.cc). Returns what it
  // wrote of that.
  nlohmann::json SendDearBatches() {
    const auto attacker = Start(
        "dear_attacker", "dear_attacker",
        {"127.0.0.1" + port_, kMission, "--keyframes", "500", "--crowd", "60", "--reversed", "60",
         "--wide", "2000", "--items", "20000", "--rounds", "2", "--out", FileOf("dear.json")},
        {});
    if (attacker == nullptr) return {};
    EXPECT_TRUE(attacker->WaitForEnd(absl::Minutes(10)));
    EXPECT_TRUE(attacker->EndStatus().ok()) << attacker->EndStatus();
    return ReadStatistics(FileOf("dear.json"));
  }

  // Expects how the calls of each attack must have ended, and what they left.
  static void ExpectHeldOff(const nlohmann::json& attacks, size_t keyframes_of_a_batch) {
    for (const auto& attack : attacks["attacks"]) {
      const std::string name = attack["name"];
      const auto ends = attack["ends"].get<std::map<std::string, int>>();
      EXPECT_FALSE(ends.empty()) << name;
      EXPECT_FALSE(ends.contains("open")) << name;
      if (name == "a number again and again") {
        EXPECT_EQ(ends.at("OK"), 20);
        EXPECT_EQ(attack["own_keyframes"], keyframes_of_a_batch);
      } else if (name == "look-ups") {
        EXPECT_TRUE(ends.contains("OK"));
        EXPECT_EQ(ends.size(), 1 + ends.count("RESOURCE_EXHAUSTED"));
      } else {
        EXPECT_FALSE(ends.contains("OK")) << name;
      }
      if (absl::StartsWith(name, "metrics: ")) {
        EXPECT_GE(ends.at("scraped"), 1) << name << ", then a scrape";
        EXPECT_FALSE(ends.contains("0") || ends.contains("500") || ends.contains("refused"))
            << name;
      }
      // Its sessions were granted, its batches were not.
      if (name == "forbidden batches") {
        EXPECT_EQ(attack["own_keyframes"], 0);
      }
    }
  }

  // Prints of each attack how its calls ended, and the robots' acknowledgements meanwhile.
  static void PrintAttacks(const nlohmann::json& attacks, const std::vector<Delay>& delays) {
    for (const auto& attack : attacks["attacks"]) {
      const std::vector<double> meanwhile = DelaysWithin(attack, delays);
      std::printf("%-40s %6.1f s, %4zu acknowledgements, p99 %5.0f ms, calls ended: %s\n",
                  attack["name"].get<std::string>().c_str(),
                  attack["ended"].get<double>() - attack["began"].get<double>(), meanwhile.size(),
                  Quantile(meanwhile, 0.99), attack["ends"].dump().c_str());
    }
  }

  // Returns the delays of batches that were due between the beginning and the end of `span`.
  static std::vector<double> DelaysWithin(const nlohmann::json& span,
                                          const std::vector<Delay>& delays) {
    const auto time = [&](const char* key) {
      return absl::UnixEpoch() + absl::Seconds(span[key].get<double>());
    };
    std::vector<double> within;
    for (const Delay& delay : delays) {
      if (time("began") <= delay.due && delay.due < time("ended")) within.push_back(delay.ms());
    }
    return within;
  }

  std::string DumpStored(const std::string& name) {
    const auto store = Reopen({.directory = FileOf(name)}, nullptr);
    EXPECT_NE(store, nullptr);
    if (store == nullptr) return name + " can't be opened";
    // Local maps may have arrived in another order.
    std::vector<std::string> lines = absl::StrSplit(
        testing::DumpLocal(kMission, *store) + testing::DumpPlaces(kMission, *store), '\n');
    std::sort(lines.begin(), lines.end());
    return absl::StrJoin(lines, "\n");
  }

  const RecordedUploads uploads_ = RecordDemo();
  std::unique_ptr<ChildProcess> store_;
  std::string port_;
  std::string metrics_;
};

TEST_F(HostileClientTest, RobotsDoNotNotice) {
  const int messages = MessagesWanted();
  // The robots drive longer than the attack lasts.
  const int laps = std::max(5, messages / 6000);
  StartStore("undisturbed");
  const std::vector<Delay> undisturbed = WaitFor(StartVictims(laps));
  const double rss_before = store_->Stop(absl::Seconds(60)).peak_rss_mb;

  StartStore("attacked");
  auto victims = StartVictims(laps);
  ASSERT_NO_FATAL_FAILURE(WaitUntilStreaming(victims));
  const nlohmann::json attacks = Attack(messages);
  const std::vector<Delay> attacked = WaitFor(victims);
  victims.clear();
  const ProcessEnd ended = store_->Stop(absl::Seconds(60));
  EXPECT_EQ(ended.exit_code, 0);
  ASSERT_TRUE(attacks.is_object());
  ExpectHeldOff(attacks, uploads_.front().full_keyframes.size());
  PrintAttacks(attacks, attacked);
  const std::vector<double> meanwhile = DelaysWithin(attacks, attacked);
  std::printf(
      "acknowledgement p99: %.1f ms undisturbed, %.1f ms under attack (%zu acknowledgements)\n"
      "the slowest: %.1f ms undisturbed, %.1f ms under attack\n"
      "store's peak memory: %.0f MB undisturbed, %.0f MB under attack\n",
      Quantile(InMs(undisturbed), 0.99), Quantile(meanwhile, 0.99), meanwhile.size(),
      Quantile(InMs(undisturbed), 1), Quantile(meanwhile, 1), rss_before, ended.peak_rss_mb);
  EXPECT_LT(ended.peak_rss_mb, rss_before + 200);
  EXPECT_EQ(testing::FirstDifference(DumpStored("attacked"), DumpStored("undisturbed")), "");
}

// What it costs the others is measured by tests/bench/dear_neighbour.cc.
TEST_F(HostileClientTest, DearNeighbourIsServedWithinLimitsAndNobodyIsLeftOut) {
  StartStore("dear");
  auto victims = StartVictims(5);
  ASSERT_NO_FATAL_FAILURE(WaitUntilStreaming(victims));
  const nlohmann::json dear = SendDearBatches();
  // All of theirs is acknowledged, in one session each.
  WaitFor(victims);
  victims.clear();
  EXPECT_EQ(store_->Stop(absl::Seconds(60)).exit_code, 0);
  ASSERT_TRUE(dear.is_object());
  for (const auto& batch : dear["batches"]) {
    EXPECT_EQ(batch["end"], "OK") << batch["kind"];
  }
  EXPECT_EQ(dear["refused"].size(), 5u);
  for (const auto& refused : dear["refused"]) {
    const bool is_price = refused["kind"] == "a keyframe moved twice";
    EXPECT_EQ(refused["code"], is_price ? "INVALID_ARGUMENT" : "RESOURCE_EXHAUSTED") << refused;
    const auto message = refused["message"].get<std::string>();
    EXPECT_TRUE(absl::StrContains(message, refused["says"].get<std::string>())) << message;
  }
}

}  // namespace
}  // namespace corbslam::tests
