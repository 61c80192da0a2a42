// Compares what a map store that is killed while four robots stream recorded uploads to it holds in
// the end with what was acknowledged, and with a store that nobody disturbed.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "fusion_worker/local_fusion_worker.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/store_dump.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/remote_uplink.h"
#include "services/runtime/child_process.h"
#include "tests/fault/replay_fixture.h"
#include "tests/replay/recorded_uploads.h"
#include "tests/replay/replaying_agent.h"

namespace corbslam::tests {

using fusion_worker::MakeLocalFusionWorker;
using services::ChildProcess;
using services::MakeChannel;
using services::MakeRemoteUplink;

namespace {

constexpr char kMission[] = "killed";
constexpr size_t kAgents = 4;

// CORBSLAM_KILLS: how often the store is killed.
int KillsWanted() { return CountFromEnvironment("CORBSLAM_KILLS", 10); }

using Agents = std::vector<std::unique_ptr<ReplayingAgent>>;

int SessionsOf(const Agents& agents) {
  int sessions = 0;
  for (const auto& agent : agents) sessions += agent->ledger().sessions;
  return sessions;
}

bool IsAnyStreaming(const Agents& agents, size_t batches) {
  return std::any_of(agents.begin(), agents.end(), [batches](const auto& agent) {
    return agent->ledger().acknowledged < batches;
  });
}

// Waits until there are more sessions than `before`, so that the next kill breaks one however long
// robots waited to come back, and returns how many there are.
int WaitForANewSession(const Agents& agents, size_t batches, int before) {
  for (int k = 0; k < 600 && SessionsOf(agents) <= before && IsAnyStreaming(agents, batches); ++k) {
    absl::SleepFor(absl::Milliseconds(50));
  }
  return SessionsOf(agents);
}

class KilledLedgerTest : public ReplayFaultTest {
 protected:
  KilledLedgerTest() {
    worker_ = Start("worker", "fusion_worker", {"--listen", "127.0.0.1:0"});
    worker_address_ = AddressOf(worker_.get());
  }

  // Starts the store on the address of the one before it, if there was one.
  void StartStore(const std::string& data_dir) {
    const std::string listen = address_.empty() ? "127.0.0.1:0" : address_;
    store_ = Start("store", "map_store",
                   {"--listen", listen, "--worker", worker_address_, "--data-dir", data_dir,
                    "--keep-everything"});
    address_ = AddressOf(store_.get());
    ASSERT_NE(address_, "");
  }

  // Robots have their first batches stored one after the other: local maps arrive in the same order
  // each time.
  Agents StartAgents(const RecordedUploads& uploads, double keyframes_per_s) {
    Agents agents;
    for (size_t i = 0; i < kAgents; ++i) {
      const ReplayOptions options{.mission = kMission,
                                  .agent = absl::StrCat("agent", i),
                                  .local_map = LocalMapId{0xa0 + i},
                                  .keyframes_per_s = keyframes_per_s};
      agents.push_back(std::make_unique<ReplayingAgent>(options, &uploads,
                                                        MakeRemoteUplink(MakeChannel(address_))));
      for (int k = 0; k < 600 && agents.back()->ledger().acknowledged == 0; ++k) {
        absl::SleepFor(absl::Milliseconds(50));
      }
      EXPECT_GT(agents.back()->ledger().acknowledged, 0u) << options.agent;
    }
    return agents;
  }

  std::unique_ptr<FusionWorker> local_worker_ = MakeLocalFusionWorker({});
  std::unique_ptr<ChildProcess> worker_;
  std::string worker_address_;
  std::unique_ptr<ChildProcess> store_;
  std::string address_;
};

TEST_F(KilledLedgerTest, HoldsWhatTheUndisturbedStoreHolds) {
  const RecordedUploads uploads = RecordDemo();
  uint64_t keyframes = 0;
  std::set<KeyframeId> kept;
  for (const MapUpdateBatch& batch : uploads) {
    keyframes += batch.full_keyframes.size();
    for (const FullKeyframe& keyframe : batch.full_keyframes) kept.insert(keyframe.payload->id);
    // Keyframes are also removed that were provisional and never came.
    for (const KeyframeRemoval& removal : batch.removed_keyframes) kept.erase(removal.id);
  }
  ASSERT_GT(kept.size(), 10u);

  const std::string undisturbed_dir = FileOf("undisturbed");
  StartStore(undisturbed_dir);
  for (const auto& agent : StartAgents(uploads, 0)) {
    const absl::Status done = agent->WaitUntilDone(absl::Seconds(120));
    EXPECT_TRUE(done.ok()) << done;
  }
  store_->Stop(absl::Seconds(60));

  const std::string killed_dir = FileOf("killed");
  StartStore(killed_dir);
  const int kills = KillsWanted();
  // Each life lasts half a second in the mean, with the start of the next about a second.
  const double pace = static_cast<double>(keyframes) / (1.0 * kills);
  Agents agents = StartAgents(uploads, pace);
  std::mt19937 random(7);
  int killed_while_streaming = 0;
  int sessions = 0;
  for (int i = 0; i < kills; ++i) {
    sessions = WaitForANewSession(agents, uploads.size(), sessions);
    absl::SleepFor(absl::Milliseconds(std::uniform_int_distribution<int>(20, 980)(random)));
    killed_while_streaming += IsAnyStreaming(agents, uploads.size()) ? 1 : 0;
    store_->Stop(absl::ZeroDuration());  // SIGKILL.
    StartStore(killed_dir);
  }
  for (const auto& agent : agents) {
    const absl::Status done = agent->WaitUntilDone(absl::Seconds(180));
    EXPECT_TRUE(done.ok()) << done;
    EXPECT_EQ(agent->ledger().keyframes, keyframes);
    EXPECT_GT(agent->ledger().sessions, 1);
  }
  EXPECT_GE(SessionsOf(agents), kills);
  EXPECT_GT(killed_while_streaming, kills * 3 / 4) << "the robots were too fast for the test";
  agents.clear();
  store_->Stop(absl::Seconds(60));
  std::printf("%d kills, %d while robots streamed; %zu robots of %lu keyframes\n", kills,
              killed_while_streaming, kAgents, static_cast<unsigned long>(keyframes));

  const auto killed = Reopen({.directory = killed_dir}, local_worker_.get());
  const auto undisturbed = Reopen({.directory = undisturbed_dir}, local_worker_.get());
  ASSERT_NE(killed, nullptr);
  ASSERT_NE(undisturbed, nullptr);
  EXPECT_EQ(killed->GetMission(kMission)->keyframes, kAgents * kept.size());
  EXPECT_EQ(
      testing::FirstDifference(LocalLayer(kMission, *killed), LocalLayer(kMission, *undisturbed)),
      "");
  EXPECT_EQ(
      testing::FirstDifference(FuseAgain(kMission, *killed), FuseAgain(kMission, *undisturbed)),
      "");
  EXPECT_EQ(killed->GetStatistics(kMission)->islands, 1u);
}

}  // namespace
}  // namespace corbslam::tests
