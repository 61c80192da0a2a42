// Tests that a robot's uplink finds the map store that has its mission, and what it says where it
// does not.
#include "services/client/remote/store_route.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "map_store/mission/mission_load.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/told_directory.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/remote_uplink.h"
#include "services/map_store_service/map_store_service.h"
#include "services/programs/default_vocabulary.h"
#include "services/security/testing/test_certificates.h"
#include "services/server/server.h"
#include "services/testing/uplink_notes.h"

namespace corbslam::services {

using map_store::MapStore;
using map_store::MapStoreOptions;
using testing::JournalOfToldDirectory;
using testing::ToldDirectory;

namespace {

using ::testing::HasSubstr;

// A store that has no missions but those that its directory does not place elsewhere.
struct FleetStore {
  explicit FleetStore(const ServerOptions& options = {}) {
    static const auto vocabulary = *Vocabulary::Load(DefaultVocabularyPath());
    store =
        std::make_unique<MapStore>(MapStoreOptions(), vocabulary,
                                   std::make_unique<JournalOfToldDirectory>(&directory), nullptr);
    service = std::make_unique<MapStoreService>(store.get());
    auto started = Server::Start("127.0.0.1:0", {service.get()}, options);
    EXPECT_TRUE(started.ok()) << started.status();
    server = *std::move(started);
  }
  ~FleetStore() {
    service->EndStreams();
    server.reset();
  }

  std::string address() const { return server->address(); }

  ToldDirectory directory;
  std::unique_ptr<MapStore> store;
  std::unique_ptr<MapStoreService> service;
  std::unique_ptr<Server> server;
};

std::shared_ptr<StoreRoute> RouteTo(const std::string& address) {
  const auto credentials = grpc::InsecureChannelCredentials();
  return std::make_shared<StoreRoute>(MakeChannel(address, credentials), ConnectWith(credentials));
}

// Returns how a session ends that some store does not grant; OK: it is granted.
absl::Status Enter(const std::shared_ptr<StoreRoute>& route) {
  UplinkNotes notes;
  const auto uplink = MakeRemoteUplink(route);
  uplink->Open({"m", "alpha", 0, {}}, &notes);
  const bool is_granted = notes.WaitForGrant().has_value();
  const absl::Status closed = is_granted ? absl::OkStatus() : notes.WaitForClose();
  uplink->Close();
  return closed;
}

TEST(StoreRouteTest, ARobotGoesWhereItsMissionIs) {
  FleetStore asked;
  FleetStore between;
  FleetStore has;
  asked.directory.Place("m", between.address());
  between.directory.Place("m", has.address());
  const absl::Status entered = Enter(RouteTo(asked.address()));
  EXPECT_TRUE(entered.ok()) << entered;
  EXPECT_FALSE(has.store->ListLoads().empty());
  EXPECT_TRUE(asked.store->ListLoads().empty());
}

TEST(StoreRouteTest, ARobotWhoseMissionMovesGoesAfterIt) {
  FleetStore a;
  FleetStore b;
  const auto uplink = MakeRemoteUplink(RouteTo(a.address()));
  UplinkNotes first;
  uplink->Open({"m", "alpha", 0, {}}, &first);
  ASSERT_TRUE(first.WaitForGrant().has_value());
  a.directory.Place("m", b.address());
  const absl::Status closed = first.WaitForClose();
  EXPECT_TRUE(absl::IsUnavailable(closed)) << closed;
  EXPECT_THAT(std::string(closed.message()), HasSubstr("mission m is not this store's any more"));
  // Robots hear of it before the store lets go of the mission.
  for (int i = 0; i < 1000 && !a.store->ListLoads().empty(); ++i) {
    absl::SleepFor(absl::Milliseconds(10));
  }
  EXPECT_TRUE(a.store->ListLoads().empty());
  // It is the next session that begins there, as batches may wait for it.
  UplinkNotes second;
  uplink->Open({"m", "alpha", 0, {}}, &second);
  EXPECT_TRUE(second.WaitForGrant().has_value());
  EXPECT_FALSE(b.store->ListLoads().empty());
  uplink->Close();
}

TEST(StoreRouteTest, StoresThatSendOnToEachOtherAreLeftAlone) {
  FleetStore a;
  FleetStore b;
  a.directory.Place("m", b.address());
  b.directory.Place("m", a.address());
  const absl::Status ended = Enter(RouteTo(a.address()));
  EXPECT_TRUE(absl::IsUnavailable(ended)) << ended;
  EXPECT_THAT(std::string(ended.message()), HasSubstr("4 stores sent on from one to the next"));
}

TEST(StoreRouteTest, WhatIsNoAddressIsNotAskedAndSaidSo) {
  FleetStore a;
  for (const char* wrong : {"unix:/tmp/socket", "xds:///anything", "host", "host:0"}) {
    a.directory.Place("m", wrong);
    const absl::Status ended = Enter(RouteTo(a.address()));
    EXPECT_THAT(std::string(ended.message()), HasSubstr(absl::StrCat(wrong, " is not asked: ")));
  }
  // Somebody who follows nobody is told where the mission is.
  a.directory.Place("m", "there:1");
  const auto alone = std::make_shared<StoreRoute>(MakeChannel(a.address()));
  EXPECT_THAT(std::string(Enter(alone).message()), HasSubstr("mission m is at there:1"));
}

TEST(StoreRouteTest, WhereTheStoreThatWasSentToHasGoneTheOneThatWasNamedIsAskedAgain) {
  FleetStore a;
  auto b = std::make_unique<FleetStore>();
  FleetStore c;
  a.directory.Place("m", b->address());
  const auto route = RouteTo(a.address());
  ASSERT_TRUE(Enter(route).ok());
  b.reset();
  a.directory.Place("m", c.address());
  EXPECT_FALSE(Enter(route).ok());
  const absl::Status entered = Enter(route);
  EXPECT_TRUE(entered.ok()) << entered;
  EXPECT_FALSE(c.store->ListLoads().empty());
}

TEST(StoreRouteTest, AStoreThatIsSentToMustProveWhoItIs) {
  const test_data::TestCertificates good("m");
  const test_data::TestCertificates other("m");
  const auto trusted = MakeServerSecurity(good.Options("store"));
  const auto stranger = MakeServerSecurity(other.Options("store"));
  ASSERT_TRUE(trusted.ok() && stranger.ok());
  FleetStore a(trusted->server);
  FleetStore impostor(stranger->server);
  FleetStore plain;
  FleetStore b(trusted->server);
  const auto credentials = MakeChannelCredentials(good.Options("alpha"));
  ASSERT_TRUE(credentials.ok()) << credentials.status();
  const auto enter = [&] {
    return Enter(std::make_shared<StoreRoute>(MakeChannel(a.address(), *credentials),
                                              ConnectWith(*credentials)));
  };
  for (const FleetStore* wrong : {&impostor, &plain}) {
    a.directory.Place("m", wrong->address());
    EXPECT_TRUE(absl::IsUnavailable(enter()));
    EXPECT_TRUE(wrong->store->ListLoads().empty());
  }
  a.directory.Place("m", b.address());
  const absl::Status entered = enter();
  EXPECT_TRUE(entered.ok()) << entered;
}

}  // namespace
}  // namespace corbslam::services
