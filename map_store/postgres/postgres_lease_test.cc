// Tests that a mission has one writer: who holds it, for how long, and what becomes of one that has
// lost it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "absl/time/clock.h"
#include "map_store/archive/state_archive.h"
#include "map_store/postgres/postgres_journal.h"
#include "map_store/testing/feature_mission.h"
#include "map_store/testing/postgres_server.h"

namespace corbslam::map_store {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::MakeFeatureMission;
using testing::PostgresServer;

constexpr char kHeld[] = "m";

class PostgresLeaseTest : public ::testing::Test {
 protected:
  std::unique_ptr<PostgresJournal> Open(const std::string& name, absl::Duration lease) {
    auto journal =
        PostgresJournal::Open({.uri = server_.Uri(database_), .lease = lease, .holder_name = name});
    EXPECT_TRUE(journal.ok()) << journal.status();
    return *std::move(journal);
  }
  static absl::Status Take(const PostgresJournal& journal) {
    Journal::Replay replay;
    replay.on_snapshot = [](MissionState) { return absl::OkStatus(); };
    replay.on_record = [](const JournalRecord&) { return absl::OkStatus(); };
    return journal.Recover(kHeld, replay).status();
  }
  static absl::Status Write(PostgresJournal& journal) {
    const auto appended = journal.Append(kHeld, RederiveRecord{});
    return appended.ok() ? journal.Sync(kHeld, *appended) : appended.status();
  }
  std::string Head() const { return server_.Ask(database_, "SELECT head FROM corbslam.missions"); }

  PostgresServer& server_ = PostgresServer::Get();
  const std::string database_ = server_.MakeDatabase();
};

TEST_F(PostgresLeaseTest, WhatIsHeldIsTakenOnceItsHolderHasGone) {
  auto first = Open("first", absl::Seconds(3));
  ASSERT_TRUE(Write(*first).ok());
  const auto second = Open("second", absl::Seconds(3));
  const absl::Status refused = Take(*second);
  EXPECT_TRUE(absl::IsUnavailable(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), AllOf(HasSubstr("(first) holds it for another")));
  // It says that it lives, also when nobody writes.
  absl::SleepFor(absl::Seconds(4));
  EXPECT_TRUE(absl::IsUnavailable(Take(*second)));
  ASSERT_TRUE(Write(*first).ok());
  first.reset();
  EXPECT_TRUE(Take(*second).ok());
  EXPECT_TRUE(Write(*second).ok());
  EXPECT_EQ(Head(), "3");
}

TEST_F(PostgresLeaseTest, AHolderThatWasSilentTooLongWritesNothingOnceAnotherOneHasTakenIt) {
  const auto silent = Open("silent", absl::Hours(3));
  ASSERT_TRUE(Write(*silent).ok());
  const auto other = Open("other", absl::Hours(3));
  EXPECT_TRUE(absl::IsUnavailable(Take(*other)));
  server_.Ask(database_, "UPDATE corbslam.missions SET lease_until = clock_timestamp()");
  // Nobody has taken it yet.
  ASSERT_TRUE(Write(*silent).ok());
  EXPECT_TRUE(absl::IsUnavailable(Take(*other)));
  server_.Ask(database_, "UPDATE corbslam.missions SET lease_until = clock_timestamp()");
  ASSERT_TRUE(Take(*other).ok());
  const absl::Status lost = Write(*silent);
  EXPECT_TRUE(absl::IsFailedPrecondition(lost)) << lost;
  EXPECT_THAT(std::string(lost.message()), HasSubstr("(other) has taken it over, in epoch 2"));
  EXPECT_EQ(Head(), "2");
  JournalSnapshot snapshot = TakeSnapshot(MakeFeatureMission(kHeld, 1, 10));
  snapshot.position = 2;
  EXPECT_FALSE(silent->WriteSnapshot(kHeld, snapshot).ok());
  EXPECT_EQ(server_.Ask(database_, "SELECT count(*) FROM corbslam.snapshots"), "0");
  EXPECT_TRUE(Write(*other).ok());
  EXPECT_EQ(Head(), "3");
}

TEST_F(PostgresLeaseTest, AMissionThatIsAsideOrMadeElsewhereIsHeldByWhoUsesIt) {
  const auto first = Open("first", absl::Hours(3));
  ASSERT_TRUE(first->CreateMission(kHeld, MakeFeatureMission(kHeld, 2, 10)).ok());
  ASSERT_TRUE(Write(*first).ok());
  ASSERT_TRUE(first->PutAside(kHeld, "summary").ok());
  const auto second = Open("second", absl::Hours(3));
  EXPECT_EQ(second->ReadSummary(kHeld).value_or(""), "summary");
  ASSERT_TRUE(Take(*second).ok());
  EXPECT_TRUE(absl::IsUnavailable(Take(*first)));
  EXPECT_TRUE(Write(*second).ok());
}

}  // namespace
}  // namespace corbslam::map_store
