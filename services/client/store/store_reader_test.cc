#include "services/client/store/store_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <utility>

#include "absl/time/clock.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/told_directory.h"
#include "services/convert/testing/test_data.h"
#include "services/map_store_service/map_store_service.h"
#include "services/programs/default_vocabulary.h"
#include "services/server/server.h"

namespace corbslam::services {

using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

using ::testing::HasSubstr;

// Nobody listens on port 1: it is reserved for tcpmux, which nobody runs.
constexpr char kNobody[] = "127.0.0.1:1";

class StoreReaderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto vocabulary = Vocabulary::Load(DefaultVocabularyPath());
    ASSERT_TRUE(vocabulary.ok()) << vocabulary.status();
    store_ = std::make_unique<MapStore>(MapStoreOptions(), *vocabulary,
                                        std::make_unique<InMemoryJournal>(), nullptr);
    service_ = std::make_unique<MapStoreService>(store_.get());
    auto server = Server::Start("127.0.0.1:0", {service_.get()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }

  std::unique_ptr<MapStore> store_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
};

TEST(ConnectToStoreTest, SaysSoonThatNobodyAnswers) {
  const absl::Time start = absl::Now();
  const absl::Status status =
      ConnectToStore(kNobody, WithoutTls(), absl::Milliseconds(500)).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()), HasSubstr(kNobody));
  EXPECT_LT(absl::Now() - start, absl::Seconds(20));
}

TEST_F(StoreReaderTest, WhoAsksAnotherStoreIsConnectedToTheOneThatHasTheMission) {
  ASSERT_TRUE(store_->CreateMission("m", {}).ok());
  testing::ToldDirectory directory;
  directory.Place("m", server_->address());
  directory.Place("lost", kNobody);
  MapStore other(MapStoreOptions(), *Vocabulary::Load(DefaultVocabularyPath()),
                 std::make_unique<testing::JournalOfToldDirectory>(&directory), nullptr);
  MapStoreService service(&other);
  const auto server = Server::Start("127.0.0.1:0", {&service});
  ASSERT_TRUE(server.ok());
  const auto channel = ConnectToStoreOf("m", (*server)->address(), WithoutTls());
  ASSERT_TRUE(channel.ok()) << channel.status();
  EXPECT_TRUE(StoreReader(*channel, "m").Statistics().ok());
  // A mission that nobody has is asked for where the caller was told.
  const auto first = ConnectToStoreOf("new", (*server)->address(), WithoutTls());
  ASSERT_TRUE(first.ok());
  EXPECT_TRUE(absl::IsNotFound(StoreReader(*first, "new").Statistics().status()));
  const absl::Status lost =
      ConnectToStoreOf("lost", (*server)->address(), WithoutTls(), absl::Milliseconds(300))
          .status();
  EXPECT_TRUE(absl::IsUnavailable(lost)) << lost;
  EXPECT_THAT(std::string(lost.message()),
              HasSubstr("mission lost is at 127.0.0.1:1 (a store of the test)"));
  EXPECT_THAT(std::string(lost.message()), HasSubstr("127.0.0.1:1 is not asked: "));
}

// A robot that was lost all the time, in a mission that another one has mapped.
TEST_F(StoreReaderTest, OfAnAgentWithoutPosesItSaysWhatBecameOfItsFrames) {
  ASSERT_TRUE(store_->CreateMission("m", {}).ok());
  SessionRequest request;
  request.mission = "m";
  request.agent = "guest";
  request.localise_only = true;
  const auto session = store_->OpenSession(request);
  ASSERT_TRUE(session.ok()) << session.status();
  LocalisedFrames part;
  part.run = part.number = 1;
  part.tracked_frames = {{3, {{9}, 1}, Rigid3d::Identity()}};
  part.lost_frames_ns = {1, 2};
  ASSERT_TRUE(store_->NoteLocalised(session->session_id, part).ok());
  const auto channel = ConnectToStore(server_->address(), WithoutTls());
  ASSERT_TRUE(channel.ok()) << channel.status();
  StoreReader reader(*channel, "m");
  for (const auto frame : {v1::TRAJECTORY_FRAME_GLOBAL, v1::TRAJECTORY_FRAME_LOCAL}) {
    UnposedFrames unposed;
    const auto served = reader.ReadTrajectory("guest", frame, PosesOf::kRectifiedCamera,
                                              StoreReader::Reach::kAllIslands, &unposed);
    ASSERT_TRUE(served.ok()) << served.status();
    EXPECT_TRUE(served->empty());
    EXPECT_EQ(Describe(unposed),
              "2 frames were lost, 1 lie elsewhere or nowhere any more, 0 are kept no more");
  }
}

TEST_F(StoreReaderTest, ReadsTheGlobalMap) {
  std::mt19937 random(7);
  SessionRequest request;
  request.mission = "m";
  request.agent = "alpha";
  const auto session = store_->OpenSession(request);
  ASSERT_TRUE(session.ok()) << session.status();
  const auto channel = ConnectToStore(server_->address(), WithoutTls());
  ASSERT_TRUE(channel.ok()) << channel.status();
  StoreReader reader(*channel, "m");
  ASSERT_TRUE(
      store_->Apply(session->session_id, test_data::MakeBatch(random, test_data::kMap, 1)).ok());
  const absl::StatusOr<ServedMap> map = reader.ReadGlobalMap();
  ASSERT_TRUE(map.ok()) << map.status();
  ASSERT_EQ(map->keyframes.size(), 2u);
  EXPECT_EQ(map->keyframes[0].agent, "alpha");
}

TEST_F(StoreReaderTest, HandsOnThatThereIsNoSuchMission) {
  const auto channel = ConnectToStore(server_->address(), WithoutTls());
  ASSERT_TRUE(channel.ok()) << channel.status();
  StoreReader reader(*channel, "nowhere");
  for (const absl::Status& status :
       {reader.ReadGlobalMap().status(), reader.Statistics().status()}) {
    EXPECT_EQ(status.code(), absl::StatusCode::kNotFound) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("there is no mission nowhere"));
  }
}

}  // namespace
}  // namespace corbslam::services
