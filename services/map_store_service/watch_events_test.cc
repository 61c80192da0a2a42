// Tests what those are told who watch a mission's events.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "services/convert/testing/test_data.h"
#include "services/map_store_service/events_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/server.h"

namespace corbslam::services {

using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;
using Event = map_store::MissionEvent;

namespace {

using test_data::kMap;
using test_data::kOtherMap;
using ::testing::ElementsAre;

constexpr char kMapName[] = "missions/m/localMaps/c0ffee00c0ffee01";

class WatchEventsTest : public ::testing::Test {
 protected:
  // One call that reads events.
  struct Watch {
    grpc::ClientContext context;
    std::unique_ptr<grpc::ClientReader<v1::MissionEvent>> stream;

    v1::MissionEvent Next() const {
      v1::MissionEvent event;
      EXPECT_TRUE(stream->Read(&event));
      return event;
    }
    grpc::StatusCode End() const {
      v1::MissionEvent event;
      while (stream->Read(&event)) {
      }
      return stream->Finish().error_code();
    }
  };

  void SetUp() override {
    store_ = std::make_unique<MapStore>(MapStoreOptions(), nullptr,
                                        std::make_unique<InMemoryJournal>(), nullptr);
    service_ = std::make_unique<MapStoreService>(store_.get());
    auto server = Server::Start("", {service_.get()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    stub_ = v1::MapStore::NewStub(server_->InProcessChannel());
    session_ = Join("alpha");
  }
  void TearDown() override { server_->Shutdown(absl::ZeroDuration()); }

  uint64_t Join(const std::string& agent) {
    SessionRequest request;
    request.mission = "m";
    request.agent = agent;
    return store_->OpenSession(request)->session_id;
  }
  void Upload(uint64_t number) {
    std::mt19937 random(7);
    ASSERT_TRUE(store_->Apply(session_, test_data::MakeBatch(random, kMap, number)).ok());
  }
  std::unique_ptr<Watch> Start(const std::string& mission, uint64_t after_number = 0) {
    auto watch = std::make_unique<Watch>();
    watch->context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(30));
    v1::WatchEventsRequest request;
    request.set_mission(mission);
    request.set_after_number(after_number);
    watch->stream = stub_->WatchEvents(&watch->context, request);
    return watch;
  }

  std::unique_ptr<MapStore> store_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<v1::MapStore::Stub> stub_;
  uint64_t session_ = 0;
};

TEST_F(WatchEventsTest, TellsWhatHappenedAndWhatHappens) {
  const auto watch = Start("missions/m");
  v1::MissionEvent event = watch->Next();
  EXPECT_EQ(event.number(), 1u);
  EXPECT_EQ(event.missed(), 0u);
  EXPECT_GT(event.time_ns(), 1'500'000'000'000'000'000);
  EXPECT_EQ(event.agent_joined().agent(), "missions/m/agents/alpha");
  Upload(1);
  event = watch->Next();
  EXPECT_EQ(event.number(), 2u);
  EXPECT_EQ(event.local_map_begun().local_map(), kMapName);
  EXPECT_EQ(event.local_map_begun().agent(), "missions/m/agents/alpha");
  while (event.event_case() != v1::MissionEvent::kAgentLeft) {
    store_->CloseSession(session_);
    event = watch->Next();
  }
  EXPECT_EQ(event.agent_left().agent(), "missions/m/agents/alpha");
  const auto late = Start("missions/m", event.number() - 1);
  EXPECT_TRUE(late->Next().has_agent_left());
  const auto of_another_life = Start("missions/m", 1000);
  EXPECT_EQ(of_another_life->Next().number(), 1u);
  watch->context.TryCancel();
  EXPECT_EQ(watch->End(), grpc::StatusCode::CANCELLED);
}

TEST_F(WatchEventsTest, WhoComesLateIsToldHowManyWereMissed) {
  for (int i = 0; i < 600; ++i) store_->CloseSession(Join("beta"));
  const auto watch = Start("missions/m", 7);
  const v1::MissionEvent first = watch->Next();
  EXPECT_EQ(first.number(), 202u);
  EXPECT_EQ(first.missed(), 194u);
  EXPECT_EQ(watch->Next().missed(), 0u);
}

TEST_F(WatchEventsTest, ASlowReaderSkipsWhatIsForgottenAndIsTold) {
  const auto watch = Start("missions/m");
  uint64_t known = watch->Next().number();
  for (int i = 0; i < 5000; ++i) store_->CloseSession(Join("beta"));
  while (known < 10001) {
    const v1::MissionEvent event = watch->Next();
    ASSERT_EQ(event.number(), known + 1 + event.missed());
    known = event.number();
  }
  EXPECT_EQ(known, 10001u);
}

TEST_F(WatchEventsTest, EndsWithItsMission) {
  const auto watch = Start("missions/m");
  watch->Next();
  ASSERT_TRUE(store_->DeleteMission("m").ok());
  EXPECT_EQ(watch->End(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(service_->streams().open_streams(), 0u);
}

TEST_F(WatchEventsTest, EndsWhenTheServerStops) {
  const auto watch = Start("missions/m");
  watch->Next();
  service_->EndStreams();
  EXPECT_EQ(watch->End(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(Start("missions/m")->End(), grpc::StatusCode::UNAVAILABLE);
}

TEST_F(WatchEventsTest, MissionsThatAreNotThereHaveNone) {
  EXPECT_EQ(Start("missions/nothing")->End(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(Start("m")->End(), grpc::StatusCode::INVALID_ARGUMENT);
}

v1::MissionEvent Convert(Event::What what) {
  v1::MissionEvent proto;
  ToProto("m",
          {.number = 3,
           .time = absl::FromUnixNanos(5),
           .revision = 8,
           .missed = 2,
           .what = std::move(what)},
          &proto);
  EXPECT_EQ(proto.number(), 3u);
  EXPECT_EQ(proto.time_ns(), 5);
  EXPECT_EQ(proto.revision(), 8u);
  EXPECT_EQ(proto.missed(), 2u);
  return proto;
}

TEST(EventsToProtoTest, EachKindHasItsNames) {
  const std::string other = "missions/m/localMaps/" + ToString(kOtherMap);
  const auto contradicted = Convert(Event::MapContradicted{"a", "b", {kMap, 0.98, 0.001}});
  EXPECT_EQ(contradicted.map_contradicted().agent(), "missions/m/agents/a");
  EXPECT_EQ(contradicted.map_contradicted().owner(), "missions/m/agents/b");
  EXPECT_EQ(contradicted.map_contradicted().local_map(), kMapName);
  EXPECT_EQ(contradicted.map_contradicted().found().scale(), 0.98);
  const auto lost = Convert(Event::TrackingLost{kMap, "a", 4});
  EXPECT_EQ(lost.tracking_lost().local_map(), kMapName);
  EXPECT_EQ(lost.tracking_lost().agent(), "missions/m/agents/a");
  EXPECT_EQ(lost.tracking_lost().frames(), 4u);
  const auto accepted = Convert(Event::OverlapAccepted{9, kMap, kOtherMap});
  EXPECT_EQ(accepted.overlap_accepted().overlap(), "missions/m/overlaps/9");
  EXPECT_THAT(accepted.overlap_accepted().local_maps(), ElementsAre(kMapName, other));
  const auto merged = Convert(Event::IslandsMerged{{kMap, kOtherMap}, {"a", "b"}, 1.5});
  EXPECT_THAT(merged.islands_merged().local_maps(), ElementsAre(kMapName, other));
  EXPECT_THAT(merged.islands_merged().agents(),
              ElementsAre("missions/m/agents/a", "missions/m/agents/b"));
  EXPECT_EQ(merged.islands_merged().ms(), 1.5);
  const auto closed = Convert(Event::LoopClosed{{kMap}, 6});
  EXPECT_THAT(closed.loop_closed().local_maps(), ElementsAre(kMapName));
  EXPECT_EQ(closed.loop_closed().overlaps(), 6u);
  const auto adjusted = Convert(Event::MapAdjusted{kMap, 10, 20, 30});
  EXPECT_EQ(adjusted.map_adjusted().island(), kMapName);
  EXPECT_EQ(adjusted.map_adjusted().keyframes(), 10u);
  EXPECT_EQ(adjusted.map_adjusted().map_points(), 20u);
  EXPECT_EQ(adjusted.map_adjusted().ms(), 30);
  const auto taken_back = Convert(Event::OverlapsTakenBack{{1, 2}});
  EXPECT_THAT(taken_back.overlaps_taken_back().overlaps(),
              ElementsAre("missions/m/overlaps/1", "missions/m/overlaps/2"));
  EXPECT_TRUE(Convert(Event::GlobalLayerForgotten{}).has_global_layer_forgotten());
}

}  // namespace
}  // namespace corbslam::services
