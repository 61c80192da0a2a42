// The connection between a robot and the map store falls silent, and no side is told: both notice,
// and the robot goes on once there is a connection again.
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <string>

#include "absl/time/clock.h"
#include "map_store/store/map_store.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/remote_uplink.h"
#include "services/convert/testing/test_data.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/server.h"
#include "services/testing/silent_proxy.h"
#include "services/testing/uplink_notes.h"

namespace corbslam::services {

using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

constexpr LocalMapId kOwn{0xabc};
constexpr absl::Duration kSecond = absl::Seconds(1);

class DeadLinkTest : public ::testing::Test {
 protected:
  // Starts both with these keepalive times.
  void Start(absl::Duration robots, absl::Duration stores) {
    ServerOptions options;
    options.keepalive_time = options.keepalive_timeout = stores;
    auto server = Server::Start("127.0.0.1:0", {&service_}, options);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    auto proxy = SilentProxy::Start(server_->address());
    ASSERT_TRUE(proxy.ok()) << proxy.status();
    proxy_ = *std::move(proxy);
    ChannelOptions channel;
    channel.keepalive_time = channel.keepalive_timeout = robots;
    channel.connect_timeout = kSecond;
    uplink_ = MakeRemoteUplink(
        MakeChannel(proxy_->address(), grpc::InsecureChannelCredentials(), channel));
  }
  void TearDown() override {
    // The robot goes first: its stream would keep the server waiting.
    uplink_.reset();
    server_.reset();
  }

  void Open(UplinkNotes& notes) {
    SessionRequest request;
    request.mission = "m";
    request.agent = "alpha";
    request.local_maps = {kOwn};
    uplink_->Open(request, &notes);
  }
  bool StoreHasSession() const {
    const auto agents = store_.ListAgents("m", {});
    return agents.ok() && !agents->items.empty() && agents->items[0].connected;
  }
  bool StoreLosesSessionWithin(absl::Duration patience) const {
    const absl::Time deadline = absl::Now() + patience;
    while (StoreHasSession() && absl::Now() < deadline) absl::SleepFor(absl::Milliseconds(20));
    return !StoreHasSession();
  }
  MapUpdateBatch Batch(uint64_t number) {
    MapUpdateBatch batch;
    batch.local_map = kOwn;
    batch.number = number;
    const auto index = static_cast<uint32_t>(number);
    auto payload = test_data::MakePayload(random_, {kOwn, index}, 5);
    batch.cameras = {payload->camera};
    batch.full_keyframes = {{payload, Rigid3d::Identity(), {}}};
    return batch;
  }

  std::mt19937 random_{3};
  MapStore store_{MapStoreOptions(), nullptr, std::make_unique<InMemoryJournal>(), nullptr};
  MapStoreService service_{&store_};
  std::unique_ptr<Server> server_;
  std::unique_ptr<SilentProxy> proxy_;
  std::unique_ptr<Uplink> uplink_;
};

TEST_F(DeadLinkTest, TheRobotNoticesAndComesAgain) {
  Start(kSecond, absl::Hours(1));
  UplinkNotes first;
  Open(first);
  ASSERT_TRUE(first.WaitForGrant().has_value());
  proxy_->SetSilent(true);
  EXPECT_TRUE(absl::IsUnavailable(first.WaitForClose())) << first.WaitForClose();
  EXPECT_TRUE(StoreHasSession()) << "nobody told it";

  // An attempt to connect while the link is silent ends soon.
  const absl::Time start = absl::Now();
  UplinkNotes second;
  Open(second);
  EXPECT_TRUE(absl::IsUnavailable(second.WaitForClose())) << second.WaitForClose();
  EXPECT_LT(absl::Now() - start, absl::Seconds(10));

  proxy_->SetSilent(false);
  bool is_open = false;
  const absl::Time deadline = absl::Now() + absl::Seconds(20);
  while (!is_open && absl::Now() < deadline) {
    UplinkNotes third;
    Open(third);
    is_open = third.WaitForGrant().has_value();
    if (is_open) {
      uplink_->Send(Batch(1));
      EXPECT_EQ(third.WaitForAcknowledgements(1), 1u);
    }
    uplink_->Close();
    absl::SleepFor(absl::Milliseconds(100));
  }
  EXPECT_TRUE(is_open);
}

TEST_F(DeadLinkTest, TheStoreNoticesARobotThatWasSilentBefore) {
  Start(absl::Hours(1), kSecond);
  UplinkNotes notes;
  Open(notes);
  ASSERT_TRUE(notes.WaitForGrant().has_value());
  // The robot is idle but alive: it is asked several times, and left alone.
  absl::SleepFor(6 * kSecond);
  EXPECT_TRUE(StoreHasSession());
  EXPECT_FALSE(notes.IsClosed());
  proxy_->SetSilent(true);
  EXPECT_TRUE(StoreLosesSessionWithin(absl::Seconds(15)));
}

}  // namespace
}  // namespace corbslam::services
