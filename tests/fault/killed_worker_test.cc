// Kills fusion workers in the middle of a request: another one, or the next one at the address,
// takes over, and the map becomes the same.
#include <gtest/gtest.h>

#include <csignal>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/store_dump.h"
#include "map_store/testing/test_agent.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/remote_fusion_worker.h"
#include "services/client/store/store_reader.h"
#include "tests/fault/fault_fixture.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;
using services::ChildProcess;
using services::ConnectToStore;
using services::MakeChannel;
using services::MakeRemoteFusionWorker;
using services::StoreReader;
using services::WithoutTls;

namespace {

using nlohmann::json;
using testing::DumpPlaces;
using testing::FirstDifference;
using testing::MakeRingMap;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TheWorld;

constexpr char kMission[] = "m";

class KilledWorkerTest : public FaultTest {
 protected:
  std::unique_ptr<ChildProcess> StartWorker(const std::string& listen = "127.0.0.1:0") {
    return Start(absl::StrCat("worker", workers_++), "fusion_worker", {"--listen", listen});
  }
  // Starts a worker that dies in a request of the kind, "midway" or when it is "done".
  std::unique_ptr<ChildProcess> StartMortal(const std::string& kind, const std::string& moment) {
    return Start(absl::StrCat("worker", workers_++), "mortal_worker",
                 {kind, "1", moment, "--listen", "127.0.0.1:0"});
  }

  // Streams two robots' maps keyframe by keyframe into a store in this process, with fusion in
  // between, all of it done by the workers.
  class Run {
   public:
    Run(const KilledWorkerTest& test, const std::vector<std::string>& addresses)
        : worker_(MakeRemoteFusionWorker(Channels(addresses))),
          store_(Options(), TheWorld().vocabulary, std::make_unique<InMemoryJournal>(),
                 worker_.get()),
          a_(store_, kMission, "a", test.map_a_),
          b_(store_, kMission, "b", test.map_b_) {}

    void Finish() {
      for (int k = 0; k < 14; ++k) {
        for (TestAgent* agent : {&a_, &b_}) {
          ASSERT_TRUE(agent->Stream(1).ok());
          ASSERT_TRUE(store_.WaitUntilFusionIdle(kMission, absl::Seconds(120)).ok());
        }
      }
      ASSERT_TRUE(a_.Close().ok());
      ASSERT_TRUE(b_.Close().ok());
      ASSERT_TRUE(store_.WaitUntilFusionIdle(kMission, absl::Seconds(120)).ok());
    }
    const MapStore& store() const { return store_; }

   private:
    static MapStoreOptions Options() {
      MapStoreOptions options;
      options.settle_after = 3;
      options.retry_ms = 20;
      return options;
    }
    static std::vector<std::shared_ptr<grpc::Channel>> Channels(
        const std::vector<std::string>& addresses) {
      std::vector<std::shared_ptr<grpc::Channel>> channels;
      for (const std::string& address : addresses) channels.push_back(MakeChannel(address));
      return channels;
    }

    const std::unique_ptr<FusionWorker> worker_;
    MapStore store_;
    TestAgent a_;
    TestAgent b_;
  };

  std::string Undisturbed() {
    const auto worker = StartWorker();
    Run run(*this, {AddressOf(worker.get())});
    run.Finish();
    EXPECT_EQ(run.store().GetStatistics(kMission)->islands, 1u);
    return DumpPlaces(kMission, run.store());
  }

  const SyntheticMap map_a_ = MakeRingMap(0xa, 0, 14);
  const SyntheticMap map_b_ = MakeRingMap(0xb, 32, 14);
  int workers_ = 0;
};

// The parameters are the kind of request and the moment of death.
class KindOfRequestTest
    : public KilledWorkerTest,
      public ::testing::WithParamInterface<std::tuple<const char*, const char*>> {
 protected:
  std::unique_ptr<ChildProcess> StartMortal() {
    return KilledWorkerTest::StartMortal(std::get<0>(GetParam()), std::get<1>(GetParam()));
  }
};

TEST_P(KindOfRequestTest, AnotherWorkerTakesOverAndTheMapIsTheSame) {
  const std::string undisturbed = Undisturbed();
  const auto mortal = StartMortal();
  const auto other = StartWorker();
  Run run(*this, {AddressOf(mortal.get()), AddressOf(other.get())});
  ASSERT_NO_FATAL_FAILURE(run.Finish());
  ASSERT_TRUE(mortal->end().has_value()) << "it was never asked";
  EXPECT_EQ(mortal->end()->exit_code, 128 + SIGKILL);
  EXPECT_EQ(FirstDifference(DumpPlaces(kMission, run.store()), undisturbed), "");
  EXPECT_EQ(run.store().GetStatistics(kMission)->failed_requests, 0u);
}

TEST_P(KindOfRequestTest, TheNextWorkerAtTheAddressTakesOverAndTheMapIsTheSame) {
  const std::string undisturbed = Undisturbed();
  const auto mortal = StartMortal();
  const std::string address = AddressOf(mortal.get());
  Run run(*this, {address});
  std::thread running([&run] { run.Finish(); });
  // This thread starts the worker, because a process ends with the thread that started it.
  const bool died = mortal->WaitForEnd(absl::Seconds(120));
  const auto next = died ? StartWorker(address) : nullptr;
  running.join();
  ASSERT_TRUE(died) << "it was never asked";
  EXPECT_EQ(FirstDifference(DumpPlaces(kMission, run.store()), undisturbed), "");
  EXPECT_EQ(run.store().GetStatistics(kMission)->failed_requests, 0u);
}

INSTANTIATE_TEST_SUITE_P(Kinds, KindOfRequestTest,
                         ::testing::Combine(::testing::Values("verify", "fuse", "adjust"),
                                            ::testing::Values("midway", "done")),
                         [](const auto& info) {
                           return absl::StrCat(std::get<0>(info.param), "_",
                                               std::get<1>(info.param));
                         });

// Everything is real, and kills come at any moment: the map is not the same to the bit, because
// what robots say comes at other times, but has the same islands, robots and keyframes.
TEST_F(KilledWorkerTest, RealRobotsAreFusedAllTheSame) {
  auto worker = StartWorker();
  const std::string worker_address = AddressOf(worker.get());
  const auto store =
      Start("store", "map_store",
            {"--listen", "127.0.0.1:0", "--worker", worker_address, "--keep-everything"});
  const std::string address = AddressOf(store.get());
  ASSERT_FALSE(address.empty());
  std::vector<std::unique_ptr<ChildProcess>> robots;
  const std::vector<std::string> names = {"alpha", "bravo"};
  for (size_t i = 0; i < names.size(); ++i) {
    robots.push_back(Start(names[i], "client_agent",
                           {"--source", absl::StrCat(DemoSource(), "?robot=", i + 1, "/2"),
                            "--server", address, "--mission", kMission, "--agent", names[i],
                            "--pace", "sensor", "--stats", FileOf(names[i] + ".json")}));
    ASSERT_NE(robots.back(), nullptr);
  }
  std::mt19937 random(1);
  const int kills = WantsLongFaults() ? 100 : 8;
  for (int i = 0; i < kills; ++i) {
    absl::SleepFor(absl::Milliseconds(std::uniform_int_distribution<int>(50, 700)(random)));
    worker->Stop(absl::ZeroDuration());  // SIGKILL.
    worker = StartWorker(worker_address);
    ASSERT_FALSE(AddressOf(worker.get()).empty());
  }
  uint64_t keyframes = 0;
  for (size_t i = 0; i < names.size(); ++i) {
    ASSERT_TRUE(robots[i]->WaitForEnd(absl::Seconds(180)));
    EXPECT_TRUE(robots[i]->EndStatus().ok()) << robots[i]->EndStatus();
    const json own = ReadStatistics(FileOf(names[i] + ".json"));
    ASSERT_TRUE(own.is_object());
    keyframes += own["keyframes"].get<uint64_t>();
  }
  const auto channel = ConnectToStore(address, WithoutTls());
  ASSERT_TRUE(channel.ok()) << channel.status();
  StoreReader reader(*channel, kMission);
  ASSERT_TRUE(reader.WaitUntilFused(absl::Seconds(300)).ok());
  const auto statistics = reader.Statistics();
  ASSERT_TRUE(statistics.ok()) << statistics.status();
  EXPECT_EQ(statistics->mission().keyframes(), keyframes);
  ASSERT_EQ(statistics->mission().islands_size(), 1);
  EXPECT_EQ(statistics->mission().islands(0).agents_size(), 2);
}

}  // namespace
}  // namespace corbslam::tests
