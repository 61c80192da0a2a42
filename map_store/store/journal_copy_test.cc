#include "map_store/store/journal_copy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "map_store/postgres/postgres_journal.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/postgres_server.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/store_dump.h"
#include "map_store/testing/test_agent.h"

namespace corbslam::map_store {
namespace {

using testing::DeterministicOptions;
using testing::DumpLocal;
using testing::MakeRingMap;
using testing::PostgresServer;
using testing::TestAgent;
using testing::TheWorld;

class JournalCopyTest : public ::testing::Test {
 protected:
  JournalCopyTest() { std::filesystem::remove_all(folder_); }
  std::unique_ptr<Journal> OpenFolder(const std::string& name) const {
    RocksJournalOptions options;
    options.directory = folder_ + "/" + name;
    std::filesystem::create_directories(options.directory);
    auto journal = RocksJournal::Open(options);
    EXPECT_TRUE(journal.ok()) << journal.status();
    return *std::move(journal);
  }
  std::unique_ptr<Journal> OpenDatabase() const {
    auto journal = PostgresJournal::Open({.uri = server_.Uri(database_)});
    EXPECT_TRUE(journal.ok()) << journal.status();
    return *std::move(journal);
  }
  // Has a store of the journal take in what a robot sends; returns what it then has.
  static std::string Fill(std::unique_ptr<Journal> journal, const std::string& mission,
                          int batches) {
    MapStore store(DeterministicOptions(), TheWorld().vocabulary, std::move(journal), nullptr);
    EXPECT_TRUE(store.Recover().ok());
    TestAgent robot(store, mission, "robot", MakeRingMap(0xa, 0, 14));
    EXPECT_TRUE(robot.Stream(batches).ok());
    return DumpLocal(mission, store);
  }
  static std::string Dump(std::unique_ptr<Journal> journal, const std::string& mission) {
    MapStore store(DeterministicOptions(), TheWorld().vocabulary, std::move(journal), nullptr);
    EXPECT_TRUE(store.Recover().ok());
    return DumpLocal(mission, store);
  }
  static std::vector<CopiedMission> Copy(const std::unique_ptr<Journal>& from,
                                         const std::unique_ptr<Journal>& to) {
    std::vector<CopiedMission> copied;
    const absl::Status status = CopyJournal(
        *from, *to, [&copied](const CopiedMission& mission) { copied.push_back(mission); });
    EXPECT_TRUE(status.ok()) << status;
    return copied;
  }

  const std::string folder_ = ::testing::TempDir() + "journal_copy";
  PostgresServer& server_ = PostgresServer::Get();
  const std::string database_ = server_.MakeDatabase();
};

TEST_F(JournalCopyTest, AFolderGoesIntoADatabaseAndBack) {
  const std::string before = Fill(OpenFolder("a"), "m", 7);
  const MissionIdentity deleted = {"gone", "uid"};
  {
    const auto folder = OpenFolder("a");
    ASSERT_TRUE(folder->NoteInList(MissionList::kDeleted, deleted).ok());
    const auto database = OpenDatabase();
    const auto copied = Copy(folder, database);
    ASSERT_EQ(copied.size(), 1u);
    EXPECT_TRUE(copied[0].status.ok()) << copied[0].status;
    EXPECT_FALSE(copied[0].was_there);
    EXPECT_EQ(copied[0].agents, 1u);
    EXPECT_EQ(copied[0].local_maps, 1u);
    EXPECT_GT(copied[0].keyframes, 0u);
    EXPECT_THAT(database->ReadList(MissionList::kDeleted), ::testing::ElementsAre(deleted));
    // Again: nothing is left to do, and nothing is doubled.
    const auto again = Copy(folder, database);
    EXPECT_TRUE(again[0].status.ok()) << again[0].status;
    EXPECT_TRUE(again[0].was_there);
    EXPECT_EQ(database->ReadList(MissionList::kDeleted).size(), 1u);
  }
  EXPECT_EQ(Dump(OpenDatabase(), "m"), before);
  ASSERT_TRUE(Copy(OpenDatabase(), OpenFolder("b"))[0].status.ok());
  EXPECT_EQ(Dump(OpenFolder("b"), "m"), before);
}

TEST_F(JournalCopyTest, AnotherMissionOfTheNameIsLeftAsItIs) {
  Fill(OpenFolder("a"), "m", 3);
  Fill(OpenFolder("a"), "n", 3);
  const std::string other = Fill(OpenDatabase(), "m", 5);
  const auto copied = Copy(OpenFolder("a"), OpenDatabase());
  ASSERT_EQ(copied.size(), 2u);
  for (const CopiedMission& mission : copied) {
    EXPECT_EQ(absl::IsAlreadyExists(mission.status), mission.name == "m") << mission.status;
    EXPECT_EQ(mission.status.ok(), mission.name == "n") << mission.status;
  }
  EXPECT_EQ(Dump(OpenDatabase(), "m"), other);
}

TEST_F(JournalCopyTest, ADamagedMissionIsNamedAndTheOthersAreCopied) {
  Fill(OpenDatabase(), "m", 3);
  Fill(OpenDatabase(), "n", 3);
  server_.Ask(database_,
              "UPDATE corbslam.records SET bytes = 'x'::bytea WHERE mission_id ="
              " (SELECT mission_id FROM corbslam.missions WHERE name = 'm')");
  const auto folder = OpenFolder("c");
  const auto copied = Copy(OpenDatabase(), folder);
  ASSERT_EQ(copied.size(), 2u);
  EXPECT_TRUE(absl::IsDataLoss(copied[0].status)) << copied[0].status;
  EXPECT_TRUE(copied[1].status.ok()) << copied[1].status;
  EXPECT_THAT(*folder->ListMissions(), ::testing::ElementsAre("n"));
}

}  // namespace
}  // namespace corbslam::map_store
