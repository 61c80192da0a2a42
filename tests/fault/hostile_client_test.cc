// A map store that robots stream to while somebody attacks it: nothing of theirs is touched, its
// memory stays bounded, and they are acknowledged as before.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/time/clock.h"
#include "map_store/testing/store_dump.h"
#include "services/corbslam/child_process.h"
#include "services/corbslam/store_reader.h"
#include "services/remote/channel.h"
#include "services/remote/remote_uplink.h"
#include "tests/fault/attacks.h"
#include "tests/fault/replay_fixture.h"
#include "tests/replay/quantile.h"
#include "tests/replay/recorded_uploads.h"
#include "tests/replay/replaying_agent.h"

namespace corbslam {
namespace {

constexpr char kMission[] = "m";
constexpr size_t kVictims = 4;
constexpr double kKeyframesPerS = 7;

// CORBSLAM_HOSTILE_MESSAGES: how many mutated ones; there are a tenth as many silent streams.
int MessagesWanted() { return CountFromEnvironment("CORBSLAM_HOSTILE_MESSAGES", 3000); }

class HostileClientTest : public ReplayFaultTest {
 protected:
  // Robots come from one host, the attacker from another: a host has so many streams.
  void StartStore(const std::string& name) {
    store_ = Start(name, "map_store",
                   {"--listen", "[::]:0", "--data-dir", FileOf(name), "--open-timeout", "3"});
    const std::string address = AddressOf(store_.get());
    ASSERT_NE(address, "");
    port_ = address.substr(address.rfind(':'));
  }

  std::vector<std::unique_ptr<ReplayingAgent>> StartVictims(int laps) const {
    std::vector<std::unique_ptr<ReplayingAgent>> agents;
    for (size_t i = 0; i < kVictims; ++i) {
      const ReplayOptions options{.mission = kMission,
                                  .agent = absl::StrCat("agent", i),
                                  .local_map = LocalMapId{0x1000 * (i + 1)},
                                  .laps = laps,
                                  .keyframes_per_s = kKeyframesPerS};
      agents.push_back(std::make_unique<ReplayingAgent>(
          options, &uploads_, MakeRemoteUplink(MakeChannel("[::1]" + port_))));
    }
    return agents;
  }

  // Their acknowledgements' latencies.
  std::vector<double> WaitFor(const std::vector<std::unique_ptr<ReplayingAgent>>& agents) const {
    std::vector<double> latencies;
    for (const auto& agent : agents) {
      const absl::Status done = agent->WaitUntilDone(absl::Minutes(30));
      EXPECT_TRUE(done.ok()) << done;
      EXPECT_EQ(agent->ledger().sessions, 1) << "it was thrown out";
      AppendDelays(agent->ledger(), latencies);
    }
    return latencies;
  }

  // All that an attacker does, one after the other.
  void Attack(int messages) {
    // Its own work is not what is measured.
    setpriority(PRIO_PROCESS, 0, 19);
    Attacker attacker("127.0.0.1" + port_, kMission, LocalMapId{0x1000}, &uploads_, 1);
    StoreReader own(MakeChannel("127.0.0.1" + port_), Attacker::kOwnMission);
    for (const auto& [what, end] : attacker.SendForbiddenBatches()) {
      ExpectEnds(what, {{end, 1}}, "OK");
    }
    // Its sessions were granted, its batches were not.
    const auto nothing = own.Statistics();
    ASSERT_TRUE(nothing.ok()) << nothing.status();
    EXPECT_EQ(nothing->mission().keyframes(), 0u);
    EXPECT_TRUE(attacker.ReplayANumber(20));
    const auto once = own.Statistics();
    ASSERT_TRUE(once.ok()) << once.status();
    EXPECT_EQ(once->mission().keyframes(), uploads_.front().full_keyframes.size());
    EXPECT_TRUE(attacker.ClaimTwoGigabytes(absl::Seconds(20)));
    EXPECT_TRUE(attacker.Dribble(absl::Seconds(20)));
    const int streams = messages / 10;
    ExpectEnds("silent streams", attacker.OpenSilentStreams("Sync", streams, absl::Seconds(40)),
               "OK");
    ExpectEnds("silent backups",
               attacker.OpenSilentStreams("RestoreMission", streams, absl::Seconds(40)), "OK");
    const Attacker::Ends look_ups = attacker.FloodWithLookups(streams, absl::Seconds(40));
    ExpectEnds("look-ups", look_ups, "");
    EXPECT_TRUE(look_ups.contains("OK"));
    EXPECT_EQ(look_ups.size(), 1 + look_ups.count("RESOURCE_EXHAUSTED"));
    ExpectEnds("mutated messages", attacker.SendMutatedMessages(messages), "OK");
  }
  // `ends` are by code; none may be open, or `never`.
  static void ExpectEnds(const std::string& what, const Attacker::Ends& ends,
                         const std::string& never) {
    for (const auto& [end, count] : ends) {
      std::printf("%s: %d ended with %s\n", what.c_str(), count, end.c_str());
      EXPECT_NE(end, "open") << what;
      EXPECT_NE(end, never) << what;
    }
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
};

TEST_F(HostileClientTest, RobotsDoNotNotice) {
  const int messages = MessagesWanted();
  // About as long as the attack lasts.
  const int laps = std::max(5, messages / 3000);
  StartStore("undisturbed");
  const double p99_before = Quantile(WaitFor(StartVictims(laps)), 0.99);
  const double rss_before = store_->Stop(absl::Seconds(60)).peak_rss_mb;

  StartStore("attacked");
  auto victims = StartVictims(laps);
  // A local map belongs to whoever sends its first batch.
  for (const auto& victim : victims) {
    for (int i = 0; i < 600 && victim->ledger().acknowledged == 0; ++i) {
      absl::SleepFor(absl::Milliseconds(10));
    }
    ASSERT_GT(victim->ledger().acknowledged, 0u);
  }
  std::thread attack([&] { Attack(messages); });
  const double p99_under_attack = Quantile(WaitFor(victims), 0.99);
  attack.join();
  victims.clear();
  const ProcessEnd ended = store_->Stop(absl::Seconds(60));
  EXPECT_EQ(ended.exit_code, 0);
  std::printf(
      "acknowledgement p99: %.1f ms undisturbed, %.1f ms under attack\n"
      "store's peak memory: %.0f MB undisturbed, %.0f MB under attack\n",
      p99_before, p99_under_attack, rss_before, ended.peak_rss_mb);
  EXPECT_LT(ended.peak_rss_mb, rss_before + 200);
  EXPECT_EQ(testing::FirstDifference(DumpStored("attacked"), DumpStored("undisturbed")), "");
}

}  // namespace
}  // namespace corbslam
