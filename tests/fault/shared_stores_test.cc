// Two map stores share a database while robots stream recorded uploads to them. The one that has
// the mission is stopped as long as its lease, and goes on later; then the other one is killed. In
// the end the mission is what it is where nobody disturbed it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/time/clock.h"
#include "map_store/postgres/postgres_journal.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/postgres_server.h"
#include "map_store/testing/store_dump.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/remote_uplink.h"
#include "services/client/remote/store_route.h"
#include "services/runtime/child_process.h"
#include "services/testing/uplink_notes.h"
#include "slam/exchange/mission_elsewhere.h"
#include "tests/fault/replay_fixture.h"
#include "tests/replay/recorded_uploads.h"
#include "tests/replay/replaying_agent.h"

namespace corbslam::tests {

using map_store::MapStore;
using map_store::MapStoreOptions;
using map_store::PostgresJournal;
using services::ChildProcess;
using services::StoreRoute;
using testing::PostgresServer;

namespace {

constexpr char kMission[] = "shared";
constexpr size_t kAgents = 3;

using Agents = std::vector<std::unique_ptr<ReplayingAgent>>;

// A robot's own would wait for half a minute for a store that says nothing.
std::shared_ptr<grpc::Channel> ConnectSoon(const std::string& address) {
  return services::MakeChannel(address, grpc::InsecureChannelCredentials(),
                               {.keepalive_time = absl::Seconds(1),
                                .keepalive_timeout = absl::Seconds(1),
                                .connect_timeout = absl::Seconds(2)});
}

class SharedStoresTest : public ReplayFaultTest {
 protected:
  std::unique_ptr<ChildProcess> StartStore(const std::string& name, const std::string& database,
                                           const std::string& listen = "127.0.0.1:0") {
    return Start(name, "map_store",
                 {"--listen", listen, "--journal", "postgres:" + server_.Uri(database),
                  "--journal-lease", "3", "--keep-everything"});
  }
  // The robots are told of the stores in turn.
  static Agents StartAgents(const RecordedUploads& uploads,
                            const std::vector<std::string>& addresses, double keyframes_per_s) {
    Agents agents;
    for (size_t i = 0; i < kAgents; ++i) {
      const auto route = std::make_shared<StoreRoute>(
          ConnectSoon(addresses[i % addresses.size()]),
          [](const std::string& address) -> absl::StatusOr<std::shared_ptr<grpc::Channel>> {
            return ConnectSoon(address);
          });
      const ReplayOptions options{.mission = kMission,
                                  .agent = absl::StrCat("agent", i),
                                  .local_map = LocalMapId{0xa0 + i},
                                  .keyframes_per_s = keyframes_per_s};
      agents.push_back(
          std::make_unique<ReplayingAgent>(options, &uploads, services::MakeRemoteUplink(route)));
      // Local maps arrive in the same order each time.
      for (int k = 0; k < 600 && agents.back()->ledger().acknowledged == 0; ++k) {
        absl::SleepFor(absl::Milliseconds(50));
      }
      EXPECT_GT(agents.back()->ledger().acknowledged, 0u) << options.agent;
    }
    return agents;
  }
  static void Finish(const Agents& agents) {
    for (const auto& agent : agents) {
      const absl::Status done = agent->WaitUntilDone(absl::Seconds(180));
      EXPECT_TRUE(done.ok()) << done;
    }
  }
  // Waits until these robots have had something more acknowledged, or all.
  static bool GoOn(const Agents& agents, const std::vector<size_t>& which, size_t batches) {
    std::map<size_t, uint64_t> before;
    for (const size_t i : which) before[i] = agents[i]->ledger().acknowledged;
    return std::ranges::all_of(before, [&](const auto& then) {
      const ReplayingAgent& agent = *agents[then.first];
      for (int k = 0; k < 600; ++k) {
        const uint64_t now = agent.ledger().acknowledged;
        if (now > then.second || now >= batches) return true;
        absl::SleepFor(absl::Milliseconds(50));
      }
      return false;
    });
  }
  // Returns the process that has the mission, of "process 12 of HOST".
  pid_t Owner() const {
    const std::vector<std::string> words =
        absl::StrSplit(server_.Ask(database_, "SELECT holder_name FROM corbslam.missions"), ' ');
    int pid = 0;
    EXPECT_TRUE(words.size() > 1 && absl::SimpleAtoi(words[1], &pid));
    return pid;
  }
  std::string Ask(const std::string& sql) const { return server_.Ask(database_, sql); }
  std::string Address() const {
    return Ask(
        "SELECT address FROM corbslam.stores, corbslam.missions WHERE stores.holder ="
        " missions.holder");
  }
  // Returns where a robot is sent on to that comes to this store alone; a store that goes on after
  // it was stopped answers soon.
  static std::optional<std::string> Elsewhere(const std::string& address) {
    for (int i = 0; i < 20; ++i) {
      const absl::Status refusal = Refusal(address);
      EXPECT_FALSE(refusal.ok()) << address << " takes in robots of a mission that it lost";
      const auto elsewhere = FindElsewhere(refusal);
      if (elsewhere.has_value()) return elsewhere->address;
      absl::SleepFor(absl::Milliseconds(500));
    }
    return std::nullopt;
  }
  // Returns what a robot is told that comes to this store alone.
  static absl::Status Refusal(const std::string& address) {
    services::UplinkNotes notes;
    const auto uplink = services::MakeRemoteUplink(ConnectSoon(address));
    uplink->Open({kMission, "stranger", 0, {}}, &notes);
    const absl::Status closed =
        notes.WaitForGrant().has_value() ? absl::OkStatus() : notes.WaitForClose();
    uplink->Close();
    return closed;
  }
  std::string ReadLocalLayer(const std::string& database) const {
    auto journal = PostgresJournal::Open({.uri = server_.Uri(database)});
    EXPECT_TRUE(journal.ok()) << journal.status();
    MapStoreOptions options;
    options.deterministic = true;
    MapStore store(options, vocabulary_, *std::move(journal), nullptr);
    EXPECT_TRUE(store.Recover().ok());
    return LocalLayer(kMission, store);
  }

  PostgresServer& server_ = PostgresServer::Get();
  const std::string database_ = server_.MakeDatabase();
  const std::string calm_database_ = server_.MakeDatabase();
};

TEST_F(SharedStoresTest, StoppedAndKilledOwnersLoseTheMissionAndRobotsNothing) {
  const RecordedUploads uploads = RecordDemo();
  uint64_t keyframes = 0;
  for (const MapUpdateBatch& batch : uploads) keyframes += batch.full_keyframes.size();
  {
    const auto calm = StartStore("calm", calm_database_);
    Finish(StartAgents(uploads, {AddressOf(calm.get())}, 0));
    calm->Stop(absl::Seconds(60));
  }

  auto first = StartStore("first", database_);
  auto second = StartStore("second", database_);
  const std::string first_address = AddressOf(first.get());
  const std::string second_address = AddressOf(second.get());
  // Every other robot is told of the store that does not have the mission. They take half a minute.
  const Agents agents =
      StartAgents(uploads, {first_address, second_address}, static_cast<double>(keyframes) / 30);
  EXPECT_EQ(Address(), first_address);
  const std::vector<size_t> told_of_first = {0, 2};
  const std::vector<size_t> told_of_second = {1};
  const std::vector<size_t> all = {0, 1, 2};
  EXPECT_TRUE(GoOn(agents, all, uploads.size()));

  const pid_t stopped = Owner();
  ASSERT_EQ(kill(stopped, SIGSTOP), 0);
  const absl::Time begin = absl::Now();
  EXPECT_TRUE(GoOn(agents, told_of_second, uploads.size()));
  std::printf("served again after %.1f s with a lease of 3 s\n",
              absl::ToDoubleSeconds(absl::Now() - begin));
  EXPECT_EQ(Address(), second_address);
  EXPECT_EQ(Ask("SELECT epoch FROM corbslam.missions"), "2");
  ASSERT_EQ(kill(stopped, SIGCONT), 0);
  EXPECT_EQ(Elsewhere(first_address), second_address);
  EXPECT_TRUE(GoOn(agents, told_of_first, uploads.size()));

  second->Stop(absl::ZeroDuration());  // SIGKILL.
  EXPECT_TRUE(GoOn(agents, told_of_first, uploads.size()));
  EXPECT_EQ(Address(), first_address);
  // Who comes back under its address serves other missions meanwhile.
  second = StartStore("second_again", database_, second_address);
  EXPECT_EQ(AddressOf(second.get()), second_address);
  EXPECT_EQ(Elsewhere(second_address), first_address);
  Finish(agents);
  for (const auto& agent : agents) EXPECT_EQ(agent->ledger().keyframes, keyframes);
  EXPECT_EQ(Ask("SELECT epoch FROM corbslam.missions"), "3");

  first->Stop(absl::Seconds(60));
  second->Stop(absl::Seconds(60));
  EXPECT_EQ(testing::FirstDifference(ReadLocalLayer(database_), ReadLocalLayer(calm_database_)),
            "");
}

}  // namespace
}  // namespace corbslam::tests
