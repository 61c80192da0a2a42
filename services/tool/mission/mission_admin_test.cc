#include "services/tool/mission/mission_admin.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "map_store/store/map_store.h"
#include "services/convert/testing/test_data.h"
#include "services/map_store_service/map_store_service.h"
#include "services/programs/default_vocabulary.h"
#include "services/server/server.h"
#include "services/testing/test_path.h"
#include "services/tool/mission/file_backups.h"
#include "services/tool/mission/mission_settings.h"

namespace corbslam::services {

using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class MissionAdminTest : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    auto vocabulary = Vocabulary::Load(DefaultVocabularyPath());
    ASSERT_TRUE(vocabulary.ok()) << vocabulary.status();
    store_ = std::make_unique<MapStore>(MapStoreOptions(), *vocabulary,
                                        std::make_unique<InMemoryJournal>(), nullptr);
    service_ = std::make_unique<MapStoreService>(store_.get());
    auto server = Server::Start("", {service_.get()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    admin_ = std::make_unique<MissionAdmin>(server_->InProcessChannel());

    SessionRequest request;
    request.mission = "m";
    request.agent = "alpha";
    const auto session = store_->OpenSession(request);
    ASSERT_TRUE(session.ok()) << session.status();
    std::mt19937 random(7);
    const MapUpdateBatch batch = test_data::MakeBatch(random, test_data::kMap, 1);
    ASSERT_TRUE(store_->Apply(session->session_id, batch).ok());
  }

  std::string File(const std::string& name) const { return (folder_ / name).string(); }

  const fs::path folder_ = TestPath("folder");
  std::unique_ptr<MapStore> store_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<MissionAdmin> admin_;
};

TEST_F(MissionAdminTest, BacksUpDeletesAndRestores) {
  uint64_t seen = 0;
  const auto bytes = admin_->BackUp("m", File("m.backup"), [&](uint64_t n) { seen = n; });
  ASSERT_TRUE(bytes.ok()) << bytes.status();
  EXPECT_EQ(*bytes, fs::file_size(File("m.backup")));
  EXPECT_EQ(seen, *bytes);
  EXPECT_EQ(*admin_->Delete("m"), 1u);
  EXPECT_TRUE(admin_->List()->empty());
  const auto restored = admin_->Restore(File("m.backup"), "m2");
  ASSERT_TRUE(restored.ok()) << restored.status();
  EXPECT_EQ(restored->name(), "missions/m2");
  EXPECT_EQ(restored->keyframes(), 2u);
  ASSERT_EQ(admin_->List()->size(), 1u);
  EXPECT_EQ(admin_->List()->front().name(), "missions/m2");
}

TEST_F(MissionAdminTest, MakesAndChangesMissions) {
  v1::Mission wanted;
  wanted.set_name("missions/n");
  wanted.set_description("ahead");
  const auto made = admin_->Create(wanted);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_EQ(made->description(), "ahead");
  EXPECT_TRUE(absl::IsAlreadyExists(admin_->Create(wanted).status()));
  const auto update = MakeUpdate({.max_keyframes = 7}, *admin_->Get("n"));
  ASSERT_TRUE(update.ok()) << update.status();
  ASSERT_TRUE(admin_->Update(*update).ok());
  EXPECT_EQ(admin_->Get("n")->limits().keyframes(), 7u);
  EXPECT_EQ(admin_->Get("n")->description(), "ahead");
  EXPECT_TRUE(absl::IsNotFound(admin_->Get("nowhere").status()));
}

TEST_F(MissionAdminTest, LeavesNoHalfFile) {
  EXPECT_TRUE(absl::IsNotFound(admin_->BackUp("nowhere", File("x")).status()));
  EXPECT_TRUE(fs::is_empty(folder_));
  ASSERT_TRUE(admin_->BackUp("m", File("m.backup")).ok());
  const auto again = admin_->BackUp("m", File("m.backup"));
  EXPECT_TRUE(absl::IsAlreadyExists(again.status()));
  EXPECT_THAT(std::string(again.status().message()), HasSubstr(File("m.backup")));
  EXPECT_TRUE(absl::IsUnavailable(admin_->BackUp("m", "/nowhere/x").status()));
}

TEST_F(MissionAdminTest, SaysWhatIsWrongWithAFile) {
  EXPECT_TRUE(absl::IsNotFound(admin_->Restore(File("nothing"), "m2").status()));
  std::ofstream(File("empty")).close();
  EXPECT_TRUE(absl::IsDataLoss(admin_->Restore(File("empty"), "m2").status()));
  std::ofstream(File("cat")) << std::string(1 << 22, 'c');
  const auto cat = admin_->Restore(File("cat"), "m2");
  EXPECT_TRUE(absl::IsFailedPrecondition(cat.status())) << cat.status();
  EXPECT_THAT(std::string(cat.status().message()), HasSubstr(File("cat")));
  ASSERT_TRUE(admin_->BackUp("m", File("m.backup")).ok());
  EXPECT_TRUE(absl::IsAlreadyExists(admin_->Restore(File("m.backup"), "m").status()));
  EXPECT_TRUE(absl::IsInvalidArgument(admin_->Restore(File("m.backup"), "a b").status()));
  fs::resize_file(File("m.backup"), fs::file_size(File("m.backup")) - 5);
  EXPECT_TRUE(absl::IsDataLoss(admin_->Restore(File("m.backup"), "m2").status()));
  EXPECT_EQ(admin_->List()->size(), 1u);
}

TEST_F(MissionAdminTest, BacksUpAllMissionsAndKeepsTheNewest) {
  std::vector<std::string> told;
  const auto run = [&](absl::Time now) {
    return BackUpAll(*admin_, {folder_.string(), 2}, now,
                     [&told](const std::string& mission, const absl::StatusOr<std::string>& file) {
                       told.push_back(mission + (file.ok() ? " done" : " failed"));
                     });
  };
  fs::create_directories(folder_ / "m");
  std::ofstream(folder_ / "m" / "mine.backup") << "stays";
  const absl::Time begin = absl::FromUnixSeconds(1'800'000'000);
  for (int hour = 0; hour < 3; ++hour) ASSERT_TRUE(run(begin + absl::Hours(hour)).ok());
  EXPECT_EQ(told, std::vector<std::string>(3, "m done"));
  EXPECT_FALSE(fs::exists(folder_ / "m" / "20270115T080000Z.backup"));
  EXPECT_TRUE(fs::exists(folder_ / "m" / "20270115T090000Z.backup"));
  EXPECT_TRUE(fs::exists(folder_ / "m" / "mine.backup"));
  const std::string newest = (folder_ / "m" / "20270115T100000Z.backup").string();
  EXPECT_TRUE(admin_->Restore(newest, "m2").ok());
  // One that is there already is kept, and said; the other mission has its own.
  EXPECT_TRUE(absl::IsAlreadyExists(run(begin + absl::Hours(2))));
  EXPECT_TRUE(fs::exists(folder_ / "m2" / "20270115T100000Z.backup"));
}

}  // namespace
}  // namespace corbslam::services
