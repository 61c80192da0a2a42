// Tests that nothing that was acknowledged is lost, and nothing is there twice, whatever becomes of
// the server, the connection, or the answer.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "map_store/archive/state_archive.h"
#include "map_store/postgres/postgres_journal.h"
#include "map_store/postgres/schema.h"
#include "map_store/testing/blank_batch.h"
#include "map_store/testing/cutting_proxy.h"
#include "map_store/testing/feature_mission.h"
#include "map_store/testing/postgres_server.h"

namespace corbslam::map_store {
namespace {

using testing::BlankBatch;
using testing::CuttingProxy;
using ::testing::HasSubstr;
using testing::MakeFeatureMission;
using testing::PostgresServer;

constexpr char kMission[] = "m";

class PostgresFaultsTest : public ::testing::Test {
 protected:
  using Moment = CuttingProxy::Moment;

  ~PostgresFaultsTest() override {
    journal_.reset();
    // A test may have left it dead, or waiting for a standby.
    server_.Ask("postgres", "ALTER SYSTEM RESET ALL");
    server_.Ask("postgres", "SELECT pg_reload_conf()");
  }

  PostgresJournalOptions Options() const {
    PostgresJournalOptions options{.uri = server_.TcpUri(database_, proxy_.port())};
    // Only Sync writes, so that a test knows when.
    options.flush_after = absl::Hours(1);
    options.statement_timeout = absl::Seconds(5);
    options.lock_timeout = absl::Seconds(1);
    options.pool_timeout = absl::Milliseconds(300);
    return options;
  }
  void Open(const PostgresJournalOptions& options) {
    journal_.reset();
    auto opened = PostgresJournal::Open(options);
    ASSERT_TRUE(opened.ok()) << opened.status();
    journal_ = *std::move(opened);
  }
  void Open() { Open(Options()); }

  // Appends the batches, and returns the last one's position.
  static Journal::Position Append(Journal& journal, uint64_t first, uint64_t last) {
    Journal::Position position = 0;
    for (uint64_t number = first; number <= last; ++number) {
      const auto appended = journal.Append(
          kMission,
          BatchRecord{"a",
                      std::make_shared<const MapUpdateBatch>(BlankBatch(LocalMapId{7}, number, 20)),
                      absl::UnixEpoch()});
      EXPECT_TRUE(appended.ok()) << appended.status();
      position = appended.value_or(0);
    }
    return position;
  }
  Journal::Position Append(uint64_t first, uint64_t last) { return Append(*journal_, first, last); }
  // Returns the numbers of the batches that are in the database, as another process finds them.
  std::vector<uint64_t> Stored() const {
    std::vector<uint64_t> numbers;
    auto other = PostgresJournal::Open({.uri = server_.Uri(database_)});
    EXPECT_TRUE(other.ok()) << other.status();
    Journal::Replay replay;
    replay.on_record = [&numbers](const JournalRecord& record) {
      numbers.push_back(std::get<BatchRecord>(record).batch->number);
      return absl::OkStatus();
    };
    const auto position = (*other)->Recover(kMission, replay);
    EXPECT_TRUE(position.ok()) << position.status();
    return numbers;
  }
  // Reads the mission in the journal that is open.
  absl::Status ReadAgain() const {
    Journal::Replay replay;
    replay.on_record = [](const JournalRecord&) { return absl::OkStatus(); };
    return journal_->Recover(kMission, replay).status();
  }
  static std::vector<uint64_t> To(uint64_t last) {
    std::vector<uint64_t> numbers;
    for (uint64_t number = 1; number <= last; ++number) numbers.push_back(number);
    return numbers;
  }

  PostgresServer& server_ = PostgresServer::Get();
  const std::string database_ = server_.MakeDatabase();
  CuttingProxy proxy_{server_.port()};
  std::unique_ptr<PostgresJournal> journal_;
};

TEST_F(PostgresFaultsTest, ACommitWhoseAnswerIsLostIsFoundToBeDone) {
  Open();
  ASSERT_TRUE(journal_->Sync(kMission, Append(1, 3)).ok());
  proxy_.CutAt("COMMIT", Moment::kAfter);
  EXPECT_TRUE(journal_->Sync(kMission, Append(4, 6)).ok());
  EXPECT_EQ(proxy_.cuts(), 1);
  ASSERT_TRUE(journal_->Sync(kMission, Append(7, 7)).ok());
  EXPECT_EQ(Stored(), To(7));
}

TEST_F(PostgresFaultsTest, ACommitThatNeverArrivedIsFoundNotToBeDone) {
  Open();
  ASSERT_TRUE(journal_->Sync(kMission, Append(1, 3)).ok());
  proxy_.CutAt("COMMIT", Moment::kBefore);
  EXPECT_TRUE(journal_->Sync(kMission, Append(4, 6)).ok());
  EXPECT_EQ(proxy_.cuts(), 1);
  EXPECT_EQ(Stored(), To(6));
}

// The first commit also makes the mission.
TEST_F(PostgresFaultsTest, TheFirstCommitMayBeLostEitherWay) {
  for (const Moment moment : {Moment::kBefore, Moment::kAfter}) {
    Open();
    proxy_.CutAt("COMMIT", moment);
    EXPECT_TRUE(journal_->Sync(kMission, Append(1, 2)).ok());
    EXPECT_EQ(Stored(), To(2));
    Open();
    ASSERT_TRUE(ReadAgain().ok());
    ASSERT_TRUE(journal_->DeleteMission(kMission).ok());
  }
}

TEST_F(PostgresFaultsTest, WhatStaysUnknownIsAnErrorAndIsFoundOutLater) {
  Open();
  ASSERT_TRUE(journal_->Sync(kMission, Append(1, 1)).ok());
  for (const Moment moment : {Moment::kAfter, Moment::kBefore}) {
    const uint64_t next = Stored().size() + 1;
    Open();
    ASSERT_TRUE(ReadAgain().ok());
    const Journal::Position last = Append(next, next + 1);
    proxy_.CutAt("COMMIT", moment, 1000);
    const absl::Status synced = journal_->Sync(kMission, last);
    EXPECT_TRUE(absl::IsUnavailable(synced)) << synced;
    EXPECT_TRUE(absl::IsUnavailable(journal_->CheckWritable()));
    proxy_.CutAt("", Moment::kNever, 0);
    EXPECT_TRUE(journal_->CheckWritable().ok());
    EXPECT_TRUE(journal_->Sync(kMission, last).ok());
    EXPECT_EQ(Stored(), To(next + 1));
  }
}

TEST_F(PostgresFaultsTest, ADeletionThatStaysUnknownLeavesNoMissionBehind) {
  Open();
  Append(1, 2);
  proxy_.CutAt("COMMIT", Moment::kAfter, 3);
  EXPECT_FALSE(journal_->Sync(kMission, 2).ok());
  ASSERT_TRUE(journal_->DeleteMission(kMission).ok());
  EXPECT_EQ(server_.Ask(database_, "SELECT count(*) FROM corbslam.missions WHERE name = 'm'"), "0");
}

TEST_F(PostgresFaultsTest, AServerThatIsKilledAndComesBackHasAllThatWasAcknowledged) {
  Open();
  ASSERT_TRUE(journal_->Sync(kMission, Append(1, 5)).ok());
  const Journal::Position last = Append(6, 8);
  server_.Kill();
  EXPECT_TRUE(absl::IsUnavailable(journal_->Sync(kMission, last)));
  const auto refused = journal_->Append(kMission, RederiveRecord{});
  EXPECT_TRUE(absl::IsUnavailable(refused.status())) << refused.status();
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("mission m"));
  server_.Start();
  EXPECT_TRUE(journal_->Sync(kMission, last).ok());
  EXPECT_EQ(Stored(), To(8));
}

// Robots stream while the server is killed again and again.
TEST_F(PostgresFaultsTest, AServerKilledUnderLoadLosesNothingAndDoublesNothing) {
  Open();
  std::atomic<uint64_t> acknowledged = 0;
  std::atomic<bool> stops = false;
  std::thread robot([&] {
    for (uint64_t number = 1; !stops; ++number) {
      absl::StatusOr<Journal::Position> appended;
      do {
        appended = journal_->Append(
            kMission,
            BatchRecord{
                "a", std::make_shared<const MapUpdateBatch>(BlankBatch(LocalMapId{7}, number, 20)),
                absl::UnixEpoch()});
        if (!appended.ok()) absl::SleepFor(absl::Milliseconds(20));
      } while (!appended.ok());
      while (!journal_->Sync(kMission, *appended).ok()) absl::SleepFor(absl::Milliseconds(20));
      acknowledged = number;
    }
  });
  for (int kills = 0; kills < 4; ++kills) {
    const uint64_t before = acknowledged;
    const absl::Time until = absl::Now() + absl::Seconds(20);
    while (acknowledged < before + 20 && absl::Now() < until) {
      absl::SleepFor(absl::Milliseconds(5));
    }
    EXPECT_GE(acknowledged, before + 20);
    server_.Kill();
    server_.Start();
  }
  stops = true;
  robot.join();
  EXPECT_EQ(Stored(), To(acknowledged));
}

TEST_F(PostgresFaultsTest, AConnectionThatTheServerEndsIsReplaced) {
  Open();
  ASSERT_TRUE(journal_->Sync(kMission, Append(1, 1)).ok());
  server_.Ask("postgres",
              "SELECT count(pg_terminate_backend(pid)) FROM pg_stat_activity WHERE usename = "
              "'corbslam'");
  EXPECT_TRUE(journal_->Sync(kMission, Append(2, 2)).ok());
  EXPECT_TRUE(journal_->CheckWritable().ok());
  EXPECT_EQ(Stored(), To(2));
}

TEST_F(PostgresFaultsTest, AWaitForAStandbyThatIsCancelledIsNoSuccess) {
  Open();
  ASSERT_TRUE(journal_->Sync(kMission, Append(1, 1)).ok());
  server_.Ask("postgres", "ALTER SYSTEM SET synchronous_standby_names = 'nobody'");
  server_.Ask("postgres", "SELECT pg_reload_conf()");
  std::atomic<bool> ends = false;
  std::atomic<int> cancelled = 0;
  std::thread canceller([&] {
    while (!ends) {
      int count = 0;
      EXPECT_TRUE(
          absl::SimpleAtoi(server_.Ask("postgres",
                                       "SELECT count(pg_cancel_backend(pid)) FROM pg_stat_activity"
                                       " WHERE wait_event = 'SyncRep'"),
                           &count));
      cancelled += count;
      absl::SleepFor(absl::Milliseconds(20));
    }
  });
  // The server takes up the setting in its own time.
  while (cancelled == 0) {
    ASSERT_TRUE(server_.QueryAll("postgres", {"CREATE TABLE probe ()", "DROP TABLE probe"}).ok());
  }
  const Journal::Position last = Append(2, 3);
  // The server then says that it has committed, with a warning.
  const absl::Status synced = journal_->Sync(kMission, last);
  ends = true;
  canceller.join();
  EXPECT_TRUE(absl::IsUnavailable(synced)) << synced;
  EXPECT_THAT(std::string(synced.message()), HasSubstr("a standby may lack it"));
  EXPECT_EQ(server_.Ask(database_, "SELECT head FROM corbslam.missions"), "3") << "on this server";
  server_.Ask("postgres", "ALTER SYSTEM RESET synchronous_standby_names");
  server_.Ask("postgres", "SELECT pg_reload_conf()");
  EXPECT_TRUE(journal_->Sync(kMission, last).ok());
  EXPECT_EQ(Stored(), To(3));
}

TEST_F(PostgresFaultsTest, APrimaryThatOnlyReadsTakesNothingUntilOneWrites) {
  Open();
  ASSERT_TRUE(journal_->Sync(kMission, Append(1, 1)).ok());
  server_.Ask("postgres", "ALTER SYSTEM SET default_transaction_read_only = on");
  server_.Ask("postgres", "SELECT pg_reload_conf()");
  absl::SleepFor(absl::Milliseconds(200));
  const Journal::Position last = Append(2, 2);
  EXPECT_TRUE(absl::IsUnavailable(journal_->Sync(kMission, last)));
  EXPECT_TRUE(absl::IsUnavailable(journal_->CheckWritable()));
  ASSERT_TRUE(server_
                  .QueryAll("postgres", {"SET default_transaction_read_only = off",
                                         "ALTER SYSTEM RESET default_transaction_read_only",
                                         "SELECT pg_reload_conf()"})
                  .ok());
  absl::SleepFor(absl::Milliseconds(200));
  EXPECT_TRUE(journal_->CheckWritable().ok());
  EXPECT_TRUE(journal_->Sync(kMission, last).ok());
  EXPECT_EQ(Stored(), To(2));
}

TEST_F(PostgresFaultsTest, ALockThatSomebodyHoldsIsWaitedForAndThenAnError) {
  Open();
  ASSERT_TRUE(journal_->Sync(kMission, Append(1, 1)).ok());
  const Journal::Position last = Append(2, 2);
  std::thread holder([&] {
    EXPECT_TRUE(server_
                    .QueryAll(database_, {"BEGIN", "SELECT 1 FROM corbslam.missions FOR UPDATE",
                                          "SELECT pg_sleep(2.5)", "COMMIT"})
                    .ok());
  });
  absl::SleepFor(absl::Milliseconds(500));
  const absl::Status synced = journal_->Sync(kMission, last);
  EXPECT_TRUE(absl::IsUnavailable(synced)) << synced;
  EXPECT_THAT(std::string(synced.message()), HasSubstr("lock timeout"));
  holder.join();
  EXPECT_TRUE(journal_->Sync(kMission, last).ok());
  EXPECT_EQ(Stored(), To(2));
}

TEST_F(PostgresFaultsTest, APoolWithoutAFreeConnectionSaysSo) {
  PostgresJournalOptions options = Options();
  options.connections = 1;
  Open(options);
  ASSERT_TRUE(journal_->Sync(kMission, Append(1, 1)).ok());
  const Journal::Position last = Append(2, 2);
  std::thread holder([&] {
    EXPECT_TRUE(server_
                    .QueryAll(database_, {"BEGIN", "SELECT 1 FROM corbslam.missions FOR UPDATE",
                                          "SELECT pg_sleep(0.9)", "COMMIT"})
                    .ok());
  });
  absl::SleepFor(absl::Milliseconds(200));
  std::thread waiter([&] { EXPECT_TRUE(journal_->Sync(kMission, last).ok()); });
  absl::SleepFor(absl::Milliseconds(100));
  const auto picture = journal_->ReadPicture(kMission, {{7}, 1});
  EXPECT_TRUE(absl::IsUnavailable(picture.status())) << picture.status();
  EXPECT_THAT(std::string(picture.status().message()), HasSubstr("all 1 connections were busy"));
  holder.join();
  waiter.join();
  EXPECT_EQ(Stored(), To(2));
}

TEST_F(PostgresFaultsTest, AnotherVersionOfTheTablesIsRefused) {
  const auto open = [&] {
    return std::string(PostgresJournal::Open(Options()).status().message());
  };
  EXPECT_EQ(open(), "");
  // A later one that this program can work with, and one that it can't.
  server_.Ask(database_, absl::StrCat("INSERT INTO corbslam.schema_versions VALUES (",
                                      kSchemaVersion + 1, ", 1)"));
  EXPECT_EQ(open(), "");
  server_.Ask(database_, absl::StrCat("INSERT INTO corbslam.schema_versions VALUES (",
                                      kSchemaVersion + 2, ", ", kSchemaVersion + 1, ")"));
  EXPECT_THAT(open(), HasSubstr("start a newer program"));
  server_.Ask(database_, "DELETE FROM corbslam.schema_versions");
  EXPECT_THAT(open(), HasSubstr("corbslam store-schema"));
  server_.Ask(database_, "DROP SCHEMA corbslam CASCADE");
  EXPECT_THAT(open(), HasSubstr("corbslam store-schema"));
}

TEST_F(PostgresFaultsTest, TheRoleHasNoMoreRightsThanItNeeds) {
  for (const char* sql :
       {"CREATE TABLE corbslam.mine (a int)", "DROP TABLE corbslam.records",
        "TRUNCATE corbslam.records", "ALTER TABLE corbslam.records ADD COLUMN a int",
        "DELETE FROM corbslam.schema_versions"}) {
    EXPECT_FALSE(server_.QueryAll(database_, {"SET SESSION AUTHORIZATION corbslam", sql}).ok())
        << sql;
  }
}

TEST_F(PostgresFaultsTest, AProcessWhoseMissionAnotherOneHasTakenOverWritesNothingMore) {
  Open();
  ASSERT_TRUE(journal_->Sync(kMission, Append(1, 2)).ok());
  EXPECT_EQ(Stored(), To(2)) << "and this other one has it now";
  const absl::Status synced = journal_->Sync(kMission, Append(3, 3));
  EXPECT_TRUE(absl::IsFailedPrecondition(synced)) << synced;
  EXPECT_THAT(std::string(synced.message()), HasSubstr("has taken it over"));
  EXPECT_TRUE(absl::IsFailedPrecondition(journal_->Append(kMission, RederiveRecord{}).status()));
  EXPECT_TRUE(absl::IsFailedPrecondition(journal_->DeleteMission(kMission)));
  EXPECT_FALSE(journal_->PutPicture(kMission, {{{7}, 1}, "jpeg", 1}, 1000).ok());
  EXPECT_EQ(Stored(), To(2));
}

TEST_F(PostgresFaultsTest, TwoProcessesDoNotMakeOneMissionTwice) {
  Open();
  auto other = PostgresJournal::Open({.uri = server_.Uri(database_)});
  ASSERT_TRUE(other.ok()) << other.status();
  ASSERT_TRUE((*other)->Sync(kMission, Append(**other, 1, 2)).ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(journal_->Sync(kMission, Append(1, 1))));
  EXPECT_FALSE(journal_->CreateMission("made", MakeFeatureMission("made", 2, 10)).ok() &&
               (*other)->CreateMission("made", MakeFeatureMission("made", 2, 10)).ok());
  EXPECT_EQ(Stored(), To(2));
}

TEST_F(PostgresFaultsTest, SnapshotsAndDeletionsOutliveLostAnswers) {
  Open();
  ASSERT_TRUE(journal_->CreateMission(kMission, MakeFeatureMission("m", 3, 50)).ok());
  const Journal::Position last = Append(1, 4);
  ASSERT_TRUE(journal_->Sync(kMission, last).ok());
  JournalSnapshot snapshot = TakeSnapshot(MakeFeatureMission("m", 2, 50));
  snapshot.position = last;
  proxy_.CutAt("UPDATE corbslam.missions SET snapshot_position", Moment::kAfter);
  EXPECT_TRUE(journal_->WriteSnapshot(kMission, snapshot).ok());
  EXPECT_EQ(proxy_.cuts(), 1);
  EXPECT_EQ(server_.Ask(database_, "SELECT count(*) FROM corbslam.records"), "0");
  EXPECT_EQ(server_.Ask(database_, "SELECT count(*) FROM corbslam.keyframes"), "2");
  EXPECT_EQ(server_.Ask(database_, "SELECT count(*) FROM corbslam.payloads"), "2");
  EXPECT_EQ(server_.Ask(database_, "SELECT count(DISTINCT generation) FROM corbslam.snapshots"),
            "1");
  proxy_.CutAt("COMMIT", Moment::kAfter);
  EXPECT_TRUE(journal_->DeleteMission(kMission).ok());
  EXPECT_EQ(server_.Ask(database_, "SELECT count(*) FROM corbslam.missions WHERE state <> 2"), "0");
}

TEST_F(PostgresFaultsTest, TheRowsOfADeletedMissionGoInTime) {
  PostgresJournalOptions options = Options();
  options.flush_after = absl::Milliseconds(10);
  Open(options);
  ASSERT_TRUE(journal_->CreateMission(kMission, MakeFeatureMission("m", 3, 50)).ok());
  ASSERT_TRUE(journal_->Sync(kMission, Append(1, 600)).ok());
  ASSERT_TRUE(journal_->DeleteMission(kMission).ok());
  const std::string left =
      "SELECT (SELECT count(*) FROM corbslam.records) + (SELECT count(*) FROM corbslam.missions) +"
      " (SELECT count(*) FROM corbslam.payloads) + (SELECT count(*) FROM corbslam.snapshots) +"
      " (SELECT count(*) FROM corbslam.keyframes)";
  const absl::Time until = absl::Now() + absl::Seconds(20);
  while (server_.Ask(database_, left) != "0" && absl::Now() < until) {
    absl::SleepFor(absl::Milliseconds(20));
  }
  EXPECT_EQ(server_.Ask(database_, left), "0");
}

TEST_F(PostgresFaultsTest, FeaturesThatAreDamagedOrLostAreDamageOfTheMission) {
  for (const char* harm :
       {"UPDATE corbslam.payloads SET bytes = set_byte(bytes, 3, 255 - get_byte(bytes, 3))",
        "DELETE FROM corbslam.payloads", "DELETE FROM corbslam.keyframes",
        "DELETE FROM corbslam.records WHERE position = 2",
        "DELETE FROM corbslam.records WHERE position = 3",
        "UPDATE corbslam.records SET pieces = 2 WHERE position = 1"}) {
    Open();
    ASSERT_TRUE(journal_->Sync(kMission, Append(1, 3)).ok());
    server_.Ask(database_, harm);
    Open();
    const absl::Status read = ReadAgain();
    EXPECT_TRUE(absl::IsDataLoss(read)) << harm << ": " << read;
    ASSERT_TRUE(journal_->DeleteMission(kMission).ok());
  }
}

TEST(PostgresUriTest, SaysWhatIsWrongAndAddsWhatIsSafe) {
  const auto read = [](const std::string& uri) { return ReadConnectionWords({.uri = uri}); };
  EXPECT_TRUE(absl::IsInvalidArgument(read("postgresql://u:secret@db1/x").status()));
  EXPECT_TRUE(absl::IsInvalidArgument(read("host=db1 password=secret").status()));
  EXPECT_TRUE(absl::IsInvalidArgument(read("nonsense").status()));
  EXPECT_TRUE(absl::IsInvalidArgument(read("host=db1 sslmod=require").status()));
  ConnectionWords words = *read("postgresql://u@db1,db2:5433/x");
  EXPECT_EQ(words["sslmode"], "verify-full");
  EXPECT_EQ(words["target_session_attrs"], "read-write");
  EXPECT_EQ(WarnOfConnection(words), "");
  EXPECT_EQ(NameOfDatabase(*read("postgresql://u@db1:5433/x")), "postgres db1:5433/x");
  EXPECT_FALSE(read("host=/run/postgresql dbname=x")->contains("sslmode"));
  words = *read("host=db1 sslmode=require dbname=x");
  EXPECT_EQ(words["sslmode"], "require");
  EXPECT_THAT(WarnOfConnection(words), HasSubstr("verify-full"));
}

}  // namespace
}  // namespace corbslam::map_store
