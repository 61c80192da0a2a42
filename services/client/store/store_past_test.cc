// Tests that a mission's past and its events are read as the store tells them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "map_store/store/map_store.h"
#include "map_store/testing/byte_journal.h"
#include "map_store/testing/small_mission.h"
#include "services/client/store/store_reader.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/server.h"

namespace corbslam::services {

using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

using ::testing::ElementsAre;

class StorePastTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto journal =
        std::make_unique<testing::ByteJournal>(std::make_shared<testing::JournalBytes>());
    for (const auto& record : testing::MakeSmallMission()) {
      ASSERT_TRUE(journal->Append("m", record).ok());
    }
    MapStoreOptions options;
    options.deterministic = true;
    store_ = std::make_unique<MapStore>(options, nullptr, std::move(journal), nullptr);
    ASSERT_TRUE(store_->Recover().ok());
    service_ = std::make_unique<MapStoreService>(store_.get());
    auto server = Server::Start("", {service_.get()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    reader_ = std::make_unique<StoreReader>(server_->InProcessChannel(), "m");
  }
  void TearDown() override { server_->Shutdown(absl::ZeroDuration()); }

  std::unique_ptr<MapStore> store_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<StoreReader> reader_;
};

TEST_F(StorePastTest, GivesOneMomentAfterTheOther) {
  std::vector<uint64_t> revisions;
  ToldMap last;
  const absl::Status status = reader_->ReplayMap(0, /*with_points=*/false, [&](const ToldMap& map) {
    revisions.push_back(map.revision);
    last = map;
    return absl::OkStatus();
  });
  ASSERT_TRUE(status.ok()) << status;
  EXPECT_THAT(revisions, ElementsAre(0, 0, 1, 1, 2));
  const auto map = reader_->ReadMap();
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->version, last.version);
  ASSERT_EQ(map->islands.size(), last.islands.size());
  EXPECT_EQ(map->CountKeyframes(), last.CountKeyframes());
  for (const auto& [id, island] : map->islands) {
    const ToldMap::Island& other = last.islands.at(id);
    EXPECT_TRUE(other.points.empty());
    for (const auto& [keyframe_id, keyframe] : island.keyframes) {
      const ToldMap::Keyframe& replayed = other.keyframes.at(keyframe_id);
      EXPECT_EQ(replayed.parent, keyframe.parent);
      EXPECT_LT((replayed.island_from_camera.translation - keyframe.island_from_camera.translation)
                    .norm(),
                1e-9);
    }
  }
  EXPECT_GT(map->islands.begin()->second.points.size(), 0u);
  EXPECT_EQ(map->AgentOf(map->islands.begin()->first), "a");
}

TEST_F(StorePastTest, AnErrorOfTheCallerEndsIt) {
  int calls = 0;
  const absl::Status status = reader_->ReplayMap(0, /*with_points=*/false, [&](const ToldMap&) {
    ++calls;
    return absl::DataLossError("enough");
  });
  EXPECT_EQ(status, absl::DataLossError("enough"));
  EXPECT_EQ(calls, 1);
}

TEST_F(StorePastTest, GivesThePastAsItIsTold) {
  std::vector<uint64_t> revisions;
  size_t points = 0;
  const auto take = [&](const v1::WatchMapResponse& message) {
    if (!message.continues()) revisions.push_back(message.revision());
    for (const auto& island : message.islands()) points += island.points().positions_size() / 3;
    return absl::OkStatus();
  };
  ASSERT_TRUE(reader_->ReadPast(100, /*with_points=*/true, take).ok());
  EXPECT_THAT(revisions, ElementsAre(0, 0, 1, 1, 2));
  EXPECT_GT(points, 0u);
  EXPECT_EQ(reader_->ReadPast(1, true, take).code(), absl::StatusCode::kInvalidArgument);
}

TEST_F(StorePastTest, GivesThePresentAsItIsTold) {
  for (const bool with_points : {true, false}) {
    ToldMap told;
    bool is_whole = false;
    size_t points = 0;
    const auto take = [&](const v1::WatchMapResponse& message) {
      EXPECT_FALSE(is_whole) << "nothing follows the last message";
      is_whole = !message.continues();
      for (const auto& island : message.islands()) points += island.points().positions_size() / 3;
      return told.Apply(message);
    };
    ASSERT_TRUE(reader_->ReadPresent(with_points, take).ok());
    EXPECT_TRUE(is_whole);
    EXPECT_EQ(told.revision, 2u);
    EXPECT_EQ(points > 0, with_points);
  }
}

TEST_F(StorePastTest, EventsEndOnceItIsQuiet) {
  SessionRequest request;
  request.mission = "m";
  request.agent = "zulu";
  ASSERT_TRUE(store_->OpenSession(request).ok());
  const auto events = reader_->ReadEvents();
  ASSERT_TRUE(events.ok()) << events.status();
  ASSERT_EQ(events->size(), 1u);
  EXPECT_EQ(events->front().agent_joined().agent(), "missions/m/agents/zulu");
}

TEST_F(StorePastTest, HandsOnThatThereIsNoSuchMission) {
  StoreReader nowhere(server_->InProcessChannel(), "nowhere");
  const auto ignore = [](const ToldMap&) { return absl::OkStatus(); };
  EXPECT_EQ(nowhere.ReplayMap(0, /*with_points=*/false, ignore).code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(nowhere.ReadMap().status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(nowhere.ReadEvents().status().code(), absl::StatusCode::kNotFound);
}

TEST(ToldMapTest, IslandsGoAndComeAnew) {
  v1::WatchMapResponse changes;
  changes.add_local_maps(1);
  changes.add_local_maps(2);
  changes.add_local_map_agents("alpha");
  for (const uint32_t slot : {1u, 2u}) {
    v1::WatchMapResponse::Island* island = changes.add_islands();
    island->set_slot(slot);
    v1::WatchMapResponse::IslandKeyframe* keyframe = island->add_keyframes();
    keyframe->mutable_id()->set_slot(slot);
    for (const double value : {1, 0, 0, 0}) {
      keyframe->mutable_camera_from_island()->add_rotation_wxyz(value);
    }
    for (const double value : {0, 0, -3}) {
      keyframe->mutable_camera_from_island()->add_translation(value);
    }
  }
  ToldMap map;
  ASSERT_TRUE(map.Apply(changes).ok());
  EXPECT_EQ(map.CountKeyframes(), 2u);
  EXPECT_EQ(map.islands.at({1}).keyframes.begin()->second.island_from_camera.translation.z(), 3);
  EXPECT_EQ(map.AgentOf({1}), "alpha");
  EXPECT_EQ(map.AgentOf({2}), "");
  changes.clear_islands();
  changes.add_removed_island_slots(2);
  changes.add_islands()->set_slot(1);
  changes.mutable_islands(0)->set_anew(true);
  ASSERT_TRUE(map.Apply(changes).ok());
  EXPECT_EQ(map.islands.size(), 1u);
  EXPECT_EQ(map.CountKeyframes(), 0u);
  changes.mutable_islands(0)->set_slot(9);
  EXPECT_EQ(map.Apply(changes).code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace corbslam::services
