// What the picture of a mission says of islands that nothing connects with the global map.
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

namespace corbslam::services {

using map_store::MapStore;
using map_store::MapStoreOptions;
using map_store::RocksJournal;

namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// A store in this process, with the journal on disk of a small mission in which nothing was fused.
class ApartPictureTest : public ::testing::Test {
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

  static std::vector<map_store::JournalRecord> Records() {
    std::vector<map_store::JournalRecord> records = testing::MakeSmallMission();
    records.erase(records.begin() + 2, records.end());
    return records;
  }

  const fs::path folder_ = fs::path(::testing::TempDir()) / "apart_picture_test";
  std::unique_ptr<MapStore> store_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<StoreReader> reader_;
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
  const absl::StatusOr<std::string> svg = RenderMapSvg(picture, SvgStyle::kAlone);
  ASSERT_TRUE(svg.ok()) << svg.status();
  EXPECT_THAT(*svg, HasSubstr("nothing connects it"));
}

}  // namespace
}  // namespace corbslam::services
