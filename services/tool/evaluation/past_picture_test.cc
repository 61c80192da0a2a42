#include "services/tool/evaluation/past_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>

#include "map_store/rocks/rocks_journal.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/small_mission.h"
#include "services/client/store/store_reader.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/server.h"
#include "services/tool/evaluation/picture.h"
#include "slam/rendering/map_snapshots.h"
#include "slam/rendering/webp_animation.h"

namespace corbslam::services {

using map_store::MapStore;
using map_store::MapStoreOptions;
using map_store::RocksJournal;

namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

// A store in this process, with the journal of a small mission on disk.
class PastPictureTest : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    auto journal = RocksJournal::Open({.directory = folder_.string()});
    ASSERT_TRUE(journal.ok()) << journal.status();
    for (const auto& record : Records()) ASSERT_TRUE((*journal)->Append("m", record).ok());
    MapStoreOptions options;
    options.deterministic = true;
    store_ = std::make_unique<MapStore>(options, nullptr, *std::move(journal), nullptr);
    ASSERT_TRUE(store_->Recover().ok());
    service_ = std::make_unique<MapStoreService>(store_.get());
    auto server = Server::Start("", {service_.get()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    reader_ = std::make_unique<StoreReader>(server_->InProcessChannel(), "m");
  }
  void TearDown() override {
    server_->Shutdown(absl::ZeroDuration());
    store_.reset();
    fs::remove_all(folder_);
  }

  virtual std::vector<map_store::JournalRecord> Records() { return testing::MakeSmallMission(); }

  const fs::path folder_ = fs::path(::testing::TempDir()) / "past_picture_test";
  std::unique_ptr<MapStore> store_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<StoreReader> reader_;
};

TEST_F(PastPictureTest, EndsWithTheMapOfNow) {
  const auto past = reader_->ReadPast(100);
  ASSERT_TRUE(past.ok()) << past.status();
  const absl::StatusOr<ServedMap> now = reader_->ReadGlobalMap();
  ASSERT_TRUE(now.ok()) << now.status();
  ToldMap last;
  ASSERT_TRUE(ForEachMoment(*past, [&](size_t, const ToldMap& map) {
                last = map;
                return absl::OkStatus();
              }).ok());
  ASSERT_EQ(last.islands.size(), 1u);
  const ToldMap::Island& island = last.islands.begin()->second;
  EXPECT_TRUE(island.in_global_frame);
  EXPECT_EQ(island.points.size(), now->points.size());
  ASSERT_EQ(island.keyframes.size(), now->keyframes.size());
  for (const ServedMap::Keyframe& keyframe : now->keyframes) {
    const auto then = island.keyframes.find(keyframe.id);
    ASSERT_NE(then, island.keyframes.end());
    EXPECT_EQ(then->second.island_from_camera.translation, keyframe.global_from_camera.translation);
    EXPECT_EQ(last.AgentOf(keyframe.id.local_map), keyframe.agent);
  }
}

TEST_F(PastPictureTest, DrawsEachMoment) {
  const auto past = reader_->ReadPast(100);
  ASSERT_TRUE(past.ok()) << past.status();
  std::vector<MapSnapshot> snapshots;
  ASSERT_TRUE(ForEachMoment(*past, [&](size_t number, const ToldMap& map) {
                EXPECT_EQ(number, snapshots.size());
                snapshots.push_back(ComposeSnapshot(map, "a", {}));
                return absl::OkStatus();
              }).ok());
  ASSERT_GE(snapshots.size(), 2u);
  EXPECT_EQ(snapshots.size(), RevisionsOf(*past).size());
  EXPECT_THAT(snapshots.back().title, StartsWith("revision "));
  ASSERT_EQ(snapshots.back().islands.size(), 1u);
  EXPECT_EQ(snapshots.back().islands[0].map.title, "a, b");
}

TEST(ComposeSnapshotTest, DrawsIslandsApartUntilTheyAreFused) {
  ToldMap map;
  map.agents = {{{1}, "a"}, {{2}, "b"}};
  for (const LocalMapId id : {LocalMapId{1}, LocalMapId{2}, LocalMapId{3}}) {
    ToldMap::Island& island = map.islands[id];
    island.in_global_frame = id.value == 1;
    if (id.value == 3) continue;  // Nothing of it has come yet.
    island.keyframes[{id, 0}] = {};
    island.points[{id, 0}] = Eigen::Vector3f(1, 0, 2);
  }
  const MapSnapshot snapshot = ComposeSnapshot(map, "a", {});
  ASSERT_EQ(snapshot.islands.size(), 2u);
  EXPECT_EQ(snapshot.islands[0].map.title, "a");
  EXPECT_EQ(snapshot.islands[1].map.title, "b (not fused)");
  const absl::StatusOr<std::string> svg = RenderSnapshotsSvg({snapshot});
  ASSERT_TRUE(svg.ok()) << svg.status();
  EXPECT_THAT(*svg, HasSubstr("b (not fused)"));
}

// Nothing was fused yet.
class ApartPictureTest : public PastPictureTest {
 protected:
  std::vector<map_store::JournalRecord> Records() override {
    std::vector<map_store::JournalRecord> records = testing::MakeSmallMission();
    records.erase(records.begin() + 2, records.end());
    return records;
  }
};

TEST_F(ApartPictureTest, SaysWhatThePictureOfNowHasNotGot) {
  const absl::StatusOr<ServedMap> now = reader_->ReadGlobalMap();
  ASSERT_TRUE(now.ok()) << now.status();
  const absl::StatusOr<ToldMap> all = reader_->ReadMap();
  ASSERT_TRUE(all.ok()) << all.status();
  EXPECT_EQ(now->elsewhere.islands, 1u);
  ASSERT_TRUE(now->elsewhere.keyframes.contains("b"));
  EXPECT_EQ(now->keyframes.size() + now->elsewhere.keyframes.at("b"), all->CountKeyframes());
  EXPECT_GT(now->elsewhere.points.at("b"), 0u);
  const MapPicture picture = ComposePicture(*now, "a", {});
  EXPECT_THAT(picture.note, HasSubstr("b ("));
  const absl::StatusOr<std::string> svg = RenderMapSvg(picture, SvgLook::kAlone);
  ASSERT_TRUE(svg.ok()) << svg.status();
  EXPECT_THAT(*svg, HasSubstr("nothing connects it"));
}

TEST_F(PastPictureTest, HandsOnWhatTheStoreSays) {
  EXPECT_EQ(reader_->ReadPast(1).status().code(), absl::StatusCode::kInvalidArgument);
  StoreReader nowhere(server_->InProcessChannel(), "nowhere");
  EXPECT_EQ(nowhere.ReadPast(10).status().code(), absl::StatusCode::kNotFound);
}

TEST(ParseMomentsTest, TakesSharesAndRevisions) {
  const std::vector<uint64_t> told = {2, 4, 6, 8, 10};
  EXPECT_THAT(*ParseMoments("0%,50%,100%", told), ElementsAre(0, 2, 4));
  EXPECT_THAT(*ParseMoments("2, 7,10", told), ElementsAre(0, 2, 4));
  EXPECT_THAT(*ParseMoments("25%", {5}), ElementsAre(0));
}

TEST(ParseMomentsTest, RefusesWhatItCantRead) {
  const std::vector<uint64_t> told = {2, 4, 6};
  for (const char* text : {"", "x", "1", "7", "-1%", "101%", "nan%", "25%,,50%", "%"}) {
    const absl::Status status = ParseMoments(text, told).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_THAT(std::string(status.message()), HasSubstr("revisions 2 to 6")) << text;
  }
  EXPECT_FALSE(ParseMoments("50%", {}).ok());
  EXPECT_FALSE(ParseMoments("0%,0%,0%,0%,0%,0%,0%,0%,0%,0%,0%,0%,0%,0%,0%,0%,0%", told).ok());
}

}  // namespace
}  // namespace corbslam::services
