// Tests that damage of a journal's files is that mission's alone whose files they are.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/store/journal_check.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/store_dump.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;
using testing::DeterministicOptions;
using testing::DumpLocal;
using ::testing::HasSubstr;
using testing::MakeRingMap;
using testing::TestAgent;
using testing::TheWorld;

// Each other one sleeps.
constexpr const char* kMissions[] = {"alpha", "beta", "gamma", "delta", "epsilon",
                                     "zeta",  "eta",  "theta", "iota",  "kappa"};
// Stands for the files beside all missions'.
constexpr char kGuard[] = "the guard";

// CORBSLAM_DAMAGED_FOLDERS says how many folders are damaged.
int FoldersWanted() {
  int folders = 40;
  const char* text = std::getenv("CORBSLAM_DAMAGED_FOLDERS");
  EXPECT_TRUE(text == nullptr || absl::SimpleAtoi(text, &folders)) << text;
  return folders;
}

class JournalDamageTest : public ::testing::Test {
 protected:
  JournalDamageTest() {
    fs::remove_all(root_);
    fs::create_directories(root_);
    // Opened several times, they have tables, files of features and a log.
    for (const size_t keyframes : {8u, 4u, 4u}) {
      auto store = Open(whole_);
      for (const char* name : kMissions) Stream(name, keyframes, *store);
    }
    {
      auto store = Open(whole_);
      for (const char* name : kMissions) dumps_[name] = DumpLocal(name, *store);
    }
    // The orderly end puts all to sleep; a mission without a summary is read at the start.
    for (size_t i = 0; i < std::size(kMissions); i += 2) {
      fs::remove(JournalFolder(whole_).PathOf(kMissions[i]) + "/SUMMARY");
    }
  }
  ~JournalDamageTest() override { fs::remove_all(root_); }

  std::unique_ptr<MapStore> Open(const std::string& folder) {
    auto journal = RocksJournal::Open({.directory = folder});
    EXPECT_TRUE(journal.ok()) << journal.status();
    if (!journal.ok()) return nullptr;
    journal_ = journal->get();
    MapStoreOptions options = DeterministicOptions();
    options.sleep_after_s = 600;
    auto store =
        std::make_unique<MapStore>(options, TheWorld().vocabulary, *std::move(journal), nullptr);
    const absl::Status recovered = store->Recover();
    EXPECT_TRUE(recovered.ok()) << recovered;
    return store;
  }
  void Stream(const std::string& mission, size_t keyframes, MapStore& store) {
    const std::string agent = absl::StrCat("robot", made_);
    maps_.push_back(std::make_unique<testing::SyntheticMap>(
        MakeRingMap(0xa00u + static_cast<uint32_t>(made_++), 0, static_cast<int>(keyframes))));
    TestAgent robot(store, mission, agent, *maps_.back());
    EXPECT_TRUE(robot.Stream().ok());
    EXPECT_TRUE(robot.Close().ok());
  }

  fs::path FolderOf(const std::string& mission) const {
    return JournalFolder(damaged_).PathOf(mission);
  }
  void CopyWhole() {
    fs::remove_all(damaged_);
    fs::copy(whole_, damaged_, fs::copy_options::recursive);
  }
  std::vector<fs::path> FilesOf(const std::string& mission) const {
    std::vector<fs::path> files;
    const fs::path folder = mission == kGuard ? fs::path(damaged_) : FolderOf(mission);
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (entry.is_regular_file()) files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    return files;
  }
  // Damages a file of the mission in one of several ways, and says how. `name` is the file's.
  std::string Damage(const std::string& mission, std::string& name) {
    const std::vector<fs::path> files = FilesOf(mission);
    const fs::path& file = files[random_() % files.size()];
    name = file.filename().string();
    const uint64_t size = fs::file_size(file);
    const uint64_t at = size == 0 ? 0 : random_() % size;
    switch (random_() % 5) {
      case 0:
        fs::remove(file);
        return absl::StrCat(file.string(), " is lost");
      case 1:
        fs::resize_file(file, at);
        return absl::StrCat(file.string(), " ends at ", at);
      case 2:
        return Overwrite(file, at, 4096);
      default:
        return Overwrite(file, at, 4);
    }
  }
  std::string Overwrite(const fs::path& file, uint64_t at, uint64_t count) {
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    stream.seekp(static_cast<std::streamoff>(at));
    const uint64_t end = std::min<uint64_t>(at + count, fs::file_size(file));
    for (uint64_t i = at; i < end; ++i) stream.put(static_cast<char>(random_()));
    return absl::StrCat(file.string(), ": ", end - at, " bytes at ", at);
  }
  // Returns the missions that are found damaged while nobody has the folder open.
  std::set<std::string> Check() {
    std::set<std::string> found;
    const absl::Status checked =
        map_store::CheckJournal(damaged_, [&found](const CheckedMission& mission) {
          if (!mission.status.ok()) found.insert(mission.name);
        });
    EXPECT_TRUE(checked.ok()) << checked;
    return found;
  }
  void ExpectWhole(const std::string& mission, MapStore& store) {
    const auto info = store.GetMission(mission);
    ASSERT_TRUE(info.ok()) << info.status();
    EXPECT_EQ(info->damage, "");
    EXPECT_EQ(DumpLocal(mission, store), dumps_.at(mission));
    SessionRequest request;
    request.mission = mission;
    request.agent = "newcomer";
    EXPECT_TRUE(store.OpenSession(request).ok());
  }

  const fs::path root_ = fs::path(::testing::TempDir()) / "journal_damage_test" /
                         ::testing::UnitTest::GetInstance()->current_test_info()->name();
  const std::string whole_ = (root_ / "whole").string();
  const std::string damaged_ = (root_ / "damaged").string();
  std::vector<std::unique_ptr<testing::SyntheticMap>> maps_;
  int made_ = 0;
  std::map<std::string, std::string> dumps_;
  RocksJournal* journal_ = nullptr;  // Of the store that was opened last.
  std::mt19937 random_{4711};
};

TEST_F(JournalDamageTest, IsThatMissionsAlone) {
  const int folders = FoldersWanted();
  int damaged = 0;
  int unharmed = 0;
  int named = 0;
  for (int i = 0; i < folders; ++i) {
    CopyWhole();
    const size_t turn = static_cast<size_t>(i) % (std::size(kMissions) + 1);
    const std::string victim = turn < std::size(kMissions) ? kMissions[turn] : kGuard;
    std::string file;
    const std::string what = Damage(victim, file);
    SCOPED_TRACE(what);
    const std::set<std::string> found = Check();
    auto store = Open(damaged_);
    ASSERT_NE(store, nullptr);
    for (const std::string mission : kMissions) {
      EXPECT_TRUE(mission == victim || !found.contains(mission));
      if (mission != victim) ExpectWhole(mission, *store);
    }
    if (victim == kGuard) continue;
    // What sleeps is not read at the start.
    journal_->ScrubNow();
    const auto info = store->GetMission(victim);
    ASSERT_TRUE(info.ok()) << info.status();
    if (info->damage.empty()) {
      // It was a file that holds nothing of the mission. Nothing is ever lost without a word.
      ExpectWhole(victim, *store);
      ++unharmed;
      continue;
    }
    ++damaged;
    named += absl::StrContains(info->damage, file) ? 1 : 0;
    EXPECT_TRUE(found.contains(victim)) << "`journal check` finds what a store finds";
    EXPECT_THAT(info->damage, HasSubstr(victim));
    EXPECT_THAT(info->damage, HasSubstr("corbslam mission restore"));
  }
  EXPECT_GT(damaged, folders / 3);
  std::printf(
      "%d folders of %zu missions: %d times the mission was damaged (%d times the file is named), "
      "%d times nothing of it was lost, else the guard was; the other missions were whole each "
      "time\n",
      folders, std::size(kMissions), damaged, named, unharmed);
}

TEST_F(JournalDamageTest, ACheckChangesNothingAndNeedsTheFolderForItself) {
  CopyWhole();
  std::map<std::string, uint64_t> before;
  for (const char* mission : kMissions) {
    for (const fs::path& file : FilesOf(mission)) before[file.string()] = fs::file_size(file);
  }
  EXPECT_TRUE(Check().empty());
  for (const char* mission : kMissions) {
    for (const fs::path& file : FilesOf(mission)) {
      EXPECT_EQ(fs::file_size(file), before.at(file.string())) << file;
    }
  }
  const auto store = Open(damaged_);
  const auto tell = [](const CheckedMission&) {};
  const absl::Status in_use = map_store::CheckJournal(damaged_, tell);
  EXPECT_TRUE(absl::IsFailedPrecondition(in_use)) << in_use;
  const absl::Status nothing = map_store::CheckJournal((root_ / "nothing").string(), tell);
  EXPECT_TRUE(absl::IsFailedPrecondition(nothing)) << nothing;
  EXPECT_FALSE(fs::exists(root_ / "nothing"));
}

TEST_F(JournalDamageTest, ADamagedMissionIsListedRefusedAndDeleted) {
  CopyWhole();
  for (const fs::path& file : FilesOf("beta")) {
    if (file.filename().string().starts_with("MANIFEST")) Overwrite(file, 0, 4096);
  }
  fs::remove(FolderOf("beta") / "SUMMARY");
  auto store = Open(damaged_);
  const auto missions = store->ListMissions({});
  ASSERT_TRUE(missions.ok());
  ASSERT_EQ(missions->items.size(), std::size(kMissions));
  EXPECT_EQ(missions->items[1].name, "beta");
  EXPECT_THAT(missions->items[1].damage, HasSubstr(FolderOf("beta").string()));
  EXPECT_EQ(store->ListDamaged().size(), 1u);
  EXPECT_TRUE(store->CheckWritable().ok()) << "the others go on";
  SessionRequest request;
  request.mission = "beta";
  request.agent = "robot";
  const absl::Status refused = store->OpenSession(request).status();
  EXPECT_TRUE(absl::IsDataLoss(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), HasSubstr("mission beta is damaged"));
  EXPECT_TRUE(absl::IsDataLoss(store->GetStatistics("beta").status()));
  EXPECT_TRUE(absl::IsDataLoss(store->RestoreMission("beta", MissionState())));
  Stream("alpha", 3, *store);
  ASSERT_TRUE(store->DeleteMission("beta").ok());
  EXPECT_FALSE(fs::exists(FolderOf("beta")));
  EXPECT_TRUE(store->ListDamaged().empty());
  Stream("beta", 3, *store);
  EXPECT_EQ(store->GetMission("beta")->keyframes, 3u);
}

// The guard of the folder holds nothing that could be lost.
TEST_F(JournalDamageTest, NothingBesideTheMissionsMatters) {
  for (int i = 0; i < 4; ++i) {
    CopyWhole();
    for (const auto& entry : fs::directory_iterator(damaged_)) {
      if (!entry.is_regular_file() || random_() % 2 == 0) continue;
      if (random_() % 2 == 0) {
        fs::remove(entry.path());
      } else {
        Overwrite(entry.path(), 0, 4096);
      }
    }
    auto store = Open(damaged_);
    ASSERT_NE(store, nullptr);
    for (const char* mission : kMissions) ExpectWhole(mission, *store);
  }
}

}  // namespace
}  // namespace corbslam::map_store
