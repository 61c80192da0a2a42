// A map store's server is stopped in the orderly way and started again while a robot streams: the
// robot's memory management over the real uplink notices and goes on by itself.
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/clock.h"
#include "client_agent/link/store_link.h"
#include "client_agent/link/testing/fake_map_jobs.h"
#include "map_store/store/map_store.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/remote_uplink.h"
#include "services/convert/testing/test_data.h"
#include "services/map_store_service/map_store_service.h"
#include "services/programs/default_vocabulary.h"
#include "services/server/server.h"

namespace corbslam::services {

using client_agent::FakeMapJobs;
using client_agent::GuardedMap;
using client_agent::StoreLink;
using client_agent::StoreLinkOptions;
using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

constexpr LocalMapId kOwn{0xabc};

class GracefulRestartTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto vocabulary = Vocabulary::Load(DefaultVocabularyPath());
    ASSERT_TRUE(vocabulary.ok()) << vocabulary.status();
    store_ = std::make_unique<MapStore>(MapStoreOptions(), *vocabulary,
                                        std::make_unique<InMemoryJournal>(), nullptr);
    StartServer("127.0.0.1:0");
  }
  void TearDown() override {
    server_.reset();
    service_.reset();
  }

  void StartServer(const std::string& address) {
    service_ = std::make_unique<MapStoreService>(store_.get());
    auto server = Server::Start(address, {service_.get()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }

  void AddKeyframe(uint32_t index) {
    Keyframe keyframe;
    keyframe.payload = test_data::MakePayload(random_, {kOwn, index}, 30);
    map_.Write([&](Map& map) { map.AddKeyframe(keyframe); });
  }
  size_t StoredKeyframes() const {
    const auto mission = store_->GetMission("m");
    return mission.ok() ? mission->keyframes : 0;
  }
  bool WaitForKeyframes(size_t count) const {
    const absl::Time deadline = absl::Now() + absl::Seconds(20);
    while (StoredKeyframes() < count && absl::Now() < deadline) {
      absl::SleepFor(absl::Milliseconds(10));
    }
    return StoredKeyframes() == count;
  }

  std::unique_ptr<MapStore> store_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
  std::mt19937 random_{7};
  FakeMapJobs jobs_;
  GuardedMap map_{kOwn};
};

TEST_F(GracefulRestartTest, TheRobotResumesWithEachKeyframeOnce) {
  const auto uplink = MakeRemoteUplink(MakeChannel(server_->address()));
  StoreLinkOptions options;
  options.mission = "m";
  options.agent = "alpha";
  options.flush_interval = absl::Milliseconds(20);
  StoreLink manager(options, uplink.get(), [](const auto&) { return std::make_shared<Words>(); });
  manager.BeginLocalMap(map_, jobs_);
  manager.Start();
  for (uint32_t k = 0; k < 10; ++k) AddKeyframe(k);
  ASSERT_TRUE(WaitForKeyframes(10)) << StoredKeyframes();

  // The open stream is drained, and then broken. What is recorded meanwhile waits.
  const std::string address = server_->address();
  const absl::Time start = absl::Now();
  std::thread stopping([this] { server_->Shutdown(absl::Milliseconds(300)); });
  for (uint32_t k = 10; k < 20; ++k) AddKeyframe(k);
  stopping.join();
  EXPECT_LT(absl::Now() - start, absl::Seconds(5));
  for (uint32_t k = 20; k < 30; ++k) AddKeyframe(k);
  server_.reset();
  service_.reset();
  ASSERT_NO_FATAL_FAILURE(StartServer(address));

  const absl::Status finished = manager.Finish(absl::Seconds(30));
  EXPECT_TRUE(finished.ok()) << finished;
  EXPECT_EQ(StoredKeyframes(), 30u);
  uplink->Close();
}

}  // namespace
}  // namespace corbslam::services
