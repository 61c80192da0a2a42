#include "services/tool/run/record_mission.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "corbslam/v1/viewer.pb.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/byte_journal.h"
#include "map_store/testing/small_mission.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/server.h"

namespace corbslam::services {

using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

using ::testing::ElementsAre;

// What a page makes of a recorded map.
struct ShownMap {
  std::vector<uint64_t> revisions;  // Of its moments.
  ToldMap last;
  size_t points = 0;  // Of all messages.
  size_t bytes = 0;
};

ShownMap Show(const ShownMission& recorded) {
  ShownMap shown;
  for (const std::string& bytes : recorded.map) {
    v1::WatchMapResponse message;
    EXPECT_TRUE(message.ParseFromString(bytes));
    EXPECT_TRUE(shown.last.Apply(message).ok());
    if (!message.continues()) shown.revisions.push_back(message.revision());
    for (const auto& island : message.islands()) {
      shown.points += island.points().positions_size() / 3;
    }
    shown.bytes += bytes.size();
  }
  return shown;
}

class RecordMissionTest : public ::testing::Test {
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

  // Returns an empty recording where there is an error, which fails the test.
  ShownMission Record(bool has_journal, size_t most_bytes = kMostRecordedBytes) {
    absl::StatusOr<ShownMission> recorded = RecordMission(
        *reader_, "m", {.robots = {"zulu"}, .has_journal = has_journal, .most_bytes = most_bytes});
    EXPECT_TRUE(recorded.ok()) << recorded.status();
    return recorded.ok() ? *std::move(recorded) : ShownMission();
  }

  std::unique_ptr<MapStore> store_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<StoreReader> reader_;
};

TEST_F(RecordMissionTest, WithAJournalThePastIsRecorded) {
  const ShownMission recorded = Record(/*has_journal=*/true);
  const ShownMap shown = Show(recorded);
  EXPECT_EQ(recorded.mission, "m");
  EXPECT_TRUE(recorded.has_past);
  EXPECT_TRUE(recorded.has_points);
  EXPECT_THAT(shown.revisions, ElementsAre(0, 0, 1, 1, 2));
  EXPECT_GT(shown.points, 0u);
  EXPECT_EQ(shown.last.CountKeyframes(), reader_->ReadMap()->CountKeyframes());
}

TEST_F(RecordMissionTest, WithoutAJournalThePresentIs) {
  const ShownMission recorded = Record(/*has_journal=*/false);
  const ShownMap shown = Show(recorded);
  EXPECT_FALSE(recorded.has_past);
  EXPECT_TRUE(recorded.has_points);
  EXPECT_THAT(shown.revisions, ElementsAre(2));
  EXPECT_GT(shown.points, 0u);
  EXPECT_EQ(shown.last.CountKeyframes(), reader_->ReadMap()->CountKeyframes());
}

// Each bound is a byte less than what was recorded before it.
TEST_F(RecordMissionTest, OfALongMapALessPartIsRecorded) {
  const size_t past = Show(Record(/*has_journal=*/true)).bytes;
  const ShownMission present = Record(/*has_journal=*/true, past - 1);
  EXPECT_FALSE(present.has_past);
  EXPECT_TRUE(present.has_points);
  EXPECT_THAT(Show(present).revisions, ElementsAre(2));
  const ShownMission bare = Record(/*has_journal=*/false, Show(present).bytes - 1);
  EXPECT_FALSE(bare.has_past);
  EXPECT_FALSE(bare.has_points);
  EXPECT_EQ(Show(bare).points, 0u);
  EXPECT_EQ(Show(bare).last.CountKeyframes(), Show(present).last.CountKeyframes());
  EXPECT_EQ(RecordMission(*reader_, "m", {.most_bytes = Show(bare).bytes - 1}).status().code(),
            absl::StatusCode::kResourceExhausted);
}

TEST_F(RecordMissionTest, TheRunsRobotsAreConnectedNoMore) {
  SessionRequest request;
  request.mission = "m";
  request.agent = "zulu";
  ASSERT_TRUE(store_->OpenSession(request).ok());
  const ShownMission recorded = Record(/*has_journal=*/false);
  v1::MissionPulse pulse;
  ASSERT_TRUE(pulse.ParseFromString(recorded.pulse));
  EXPECT_TRUE(pulse.store_answers());
  EXPECT_GT(pulse.time_ns(), 0);
  EXPECT_EQ(pulse.mission().name(), "missions/m");
  EXPECT_EQ(pulse.mission().revision(), 2u);
  EXPECT_EQ(pulse.mission().connected_agents(), 0u);
  EXPECT_EQ(pulse.statistics().connected_agents(), 0u);
  EXPECT_EQ(pulse.local_maps_size(), 2);
  ASSERT_EQ(pulse.agents_size(), 3);
  for (const v1::MissionAgent& agent : pulse.agents()) {
    EXPECT_FALSE(agent.connected()) << agent.name();
    EXPECT_EQ(agent.left_on_purpose(), agent.name() == "missions/m/agents/zulu") << agent.name();
  }
  ASSERT_FALSE(recorded.overlaps.empty());
  v1::Overlap overlap;
  EXPECT_TRUE(overlap.ParseFromString(recorded.overlaps.front()));
}

TEST_F(RecordMissionTest, OtherPeoplesRobotsAreAsTheStoreHasThem) {
  SessionRequest request;
  request.mission = "m";
  for (const char* agent : {"zulu", "yankee"}) {
    request.agent = agent;
    ASSERT_TRUE(store_->OpenSession(request).ok());
  }
  v1::MissionPulse pulse;
  ASSERT_TRUE(pulse.ParseFromString(Record(/*has_journal=*/false).pulse));
  EXPECT_EQ(pulse.mission().connected_agents(), 1u);
  EXPECT_EQ(pulse.statistics().connected_agents(), 1u);
  for (const v1::MissionAgent& agent : pulse.agents()) {
    EXPECT_EQ(agent.connected(), agent.name() == "missions/m/agents/yankee") << agent.name();
  }
}

TEST_F(RecordMissionTest, HandsOnWhatTheStoreSays) {
  StoreReader nowhere(server_->InProcessChannel(), "nowhere");
  for (const bool has_journal : {true, false}) {
    EXPECT_EQ(RecordMission(nowhere, "nowhere", {.has_journal = has_journal}).status().code(),
              absl::StatusCode::kNotFound);
  }
}

}  // namespace
}  // namespace corbslam::services
