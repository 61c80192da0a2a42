// Tests a robot's outbox, its spool folder, the wire and the store together, over restarts of both.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <random>
#include <string>

#include "client_agent/link/store_link.h"
#include "client_agent/link/testing/fake_map_jobs.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/remote_uplink.h"
#include "services/convert/batch_bytes.h"
#include "services/convert/testing/test_data.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/server.h"

namespace corbslam::services {

using client_agent::FakeMapJobs;
using client_agent::GuardedMap;
using client_agent::OpenSpoolFolder;
using client_agent::Spool;
using client_agent::StoreLink;
using client_agent::StoreLinkOptions;
using client_agent::UploadStatus;
using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

constexpr LocalMapId kFirst{0x11};
constexpr LocalMapId kSecond{0x22};

// Stands for one map store process.
struct RunningStore {
  explicit RunningStore(const std::string& address = "")
      : store(MapStoreOptions(), nullptr, std::make_unique<InMemoryJournal>(), nullptr),
        service(&store),
        server(*Server::Start(address, {&service})) {}
  ~RunningStore() { server->Shutdown(absl::ZeroDuration()); }

  MapStore store;
  MapStoreService service;
  std::unique_ptr<Server> server;
};

// Stands for one robot process, with its map.
class Robot {
 public:
  Robot(const std::shared_ptr<grpc::Channel>& channel, const std::string& folder)
      : uplink_(MakeRemoteUplink(channel)) {
    StoreLinkOptions options;
    options.mission = "m";
    options.agent = "alpha";
    options.hold_newest_keyframes = 0;
    options.max_outbox_bytes = 0;
    options.flush_interval = options.min_backoff = absl::Milliseconds(10);
    options.max_backoff = absl::Milliseconds(50);
    auto spool = Spool::Open({.owner = "missions/m/agents/alpha"}, *OpenSpoolFolder(folder),
                             {&EncodeBatch, &DecodeBatch});
    EXPECT_TRUE(spool.ok()) << spool.status();
    memory_ = std::make_unique<StoreLink>(
        options, uplink_.get(), [](const auto&) { return std::make_shared<Words>(); },
        *std::move(spool));
    memory_->Start();
  }

  void Begin(LocalMapId id) {
    map_ = maps_.emplace_back(std::make_unique<GuardedMap>(id)).get();
    memory_->BeginLocalMap(*map_, jobs_);
  }
  void AddKeyframe(uint32_t index) {
    Keyframe keyframe;
    keyframe.payload = test_data::MakePayload(random_, {map_->local_map(), index}, 20);
    map_->Write([&](Map& map) { map.AddKeyframe(std::move(keyframe)); });
  }
  template <typename Condition>
  bool WaitUntil(const Condition& condition) {
    const absl::Time deadline = absl::Now() + absl::Seconds(20);
    while (!condition(*memory_) && absl::Now() < deadline) absl::SleepFor(absl::Milliseconds(5));
    return condition(*memory_);
  }
  StoreLink& memory() { return *memory_; }

 private:
  const std::unique_ptr<Uplink> uplink_;
  FakeMapJobs jobs_;
  std::vector<std::unique_ptr<GuardedMap>> maps_;
  GuardedMap* map_ = nullptr;
  std::mt19937 random_{1};
  // Declared last, as it reads the map until it is destroyed.
  std::unique_ptr<StoreLink> memory_;
};

class SpooledUploadTest : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::remove_all(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  const std::string folder_ = ::testing::TempDir() + "/spooled_" +
                              ::testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST_F(SpooledUploadTest, ARestartedRobotSendsWhatItHadAndGoesOn) {
  {
    // Nobody listens at this address.
    Robot robot(MakeChannel("127.0.0.1:1"), folder_);
    robot.Begin(kFirst);
    for (uint32_t k = 0; k < 30; ++k) robot.AddKeyframe(k);
    EXPECT_TRUE(robot.WaitUntil([](auto& m) {
      const UploadStatus status = m.upload();
      return status.spool_bytes > 10000 && status.memory_bytes == 0;
    }));
  }
  RunningStore running;
  Robot robot(running.server->InProcessChannel(), folder_);
  robot.Begin(kSecond);
  robot.AddKeyframe(0);
  const absl::Status finished = robot.memory().Finish(absl::Seconds(20));
  EXPECT_TRUE(finished.ok()) << finished;
  const auto first = running.store.GetLocalMap("m", kFirst);
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_EQ(first->keyframes, 30u);
  EXPECT_TRUE(first->closed);
  EXPECT_EQ(running.store.GetLocalMap("m", kSecond)->keyframes, 1u);
  EXPECT_TRUE(robot.WaitUntil([](auto& m) { return m.upload().spool_bytes == 0; }));
}

TEST_F(SpooledUploadTest, AStoreThatForgotIsDataLossAndTakesANewLocalMap) {
  auto store = std::make_unique<RunningStore>("127.0.0.1:0");
  const std::string address = store->server->address();
  Robot robot(MakeChannel(address), folder_);
  robot.Begin(kFirst);
  robot.AddKeyframe(0);
  EXPECT_TRUE(robot.WaitUntil([](auto& m) { return m.first_acknowledged().has_value(); }));
  store.reset();
  store = std::make_unique<RunningStore>(address);
  EXPECT_TRUE(robot.WaitUntil([](auto& m) { return m.NeedsNewLocalMap(); }));
  EXPECT_TRUE(absl::IsDataLoss(robot.memory().upload().loss)) << robot.memory().upload().loss;
  robot.Begin(kSecond);
  robot.AddKeyframe(0);
  const absl::Status finished = robot.memory().Finish(absl::Seconds(20));
  EXPECT_TRUE(finished.ok()) << finished;
  EXPECT_EQ(store->store.GetLocalMap("m", kSecond)->keyframes, 1u);
}

}  // namespace
}  // namespace corbslam::services
