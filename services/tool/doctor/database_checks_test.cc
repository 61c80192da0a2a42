#include "services/tool/doctor/database_checks.h"

#include <gtest/gtest.h>

#include "map_store/testing/postgres_server.h"

namespace corbslam::services {
namespace {

using map_store::DirectoryStore;
using map_store::StandbyCounts;
using testing::PostgresServer;

DirectoryStore Alive(const std::string& name) {
  DirectoryStore store;
  store.name = name;
  store.lease_left = absl::Seconds(5);
  return store;
}

TEST(DatabaseChecksTest, StandbysAreToBeMoreThanCommitsWaitFor) {
  EXPECT_EQ(JudgeStandbys(std::nullopt).level, Level::kOk);
  EXPECT_EQ(JudgeStandbys(StandbyCounts{0, 2}).level, Level::kWarn);
  EXPECT_EQ(JudgeStandbys(StandbyCounts{1, 0}).level, Level::kFail);
  EXPECT_EQ(JudgeStandbys(StandbyCounts{1, 1}).level, Level::kWarn);
  EXPECT_EQ(JudgeStandbys(StandbyCounts{1, 2}).level, Level::kOk);
}

TEST(DatabaseChecksTest, StoresThatAreGoneOrBusyAreNamed) {
  EXPECT_TRUE(JudgeStores({}).empty());
  DirectoryStore gone = Alive("gone");
  gone.lease_left = absl::ZeroDuration();
  DirectoryStore busy = Alive("busy");
  busy.load = map_store::StoreLoad{0.9, 1, 0, 0, 0};
  Findings found = JudgeStores({Alive("calm"), gone, busy});
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0].level, Level::kOk);
  EXPECT_EQ(found[1].level, Level::kWarn);
  EXPECT_EQ(found[2].text, "its load is 90 %");
  busy.is_cordoned = true;
  found = JudgeStores({gone, busy});
  EXPECT_EQ(found.back().level, Level::kFail);
}

TEST(DatabaseChecksTest, ADatabaseIsAskedForAll) {
  PostgresServer& server = PostgresServer::Get();
  JournalFlags journal;
  journal.journal = "postgres:" + server.Uri(server.MakeDatabase());
  const Findings found = CheckDatabase(journal);
  EXPECT_FALSE(AnyFailed(found)) << FormatFindings(found);
  EXPECT_EQ(found.front().level, Level::kOk);
  journal.journal = "postgres:" + server.Uri("nowhere");
  EXPECT_TRUE(AnyFailed(CheckDatabase(journal)));
  journal.journal = "postgres:" + server.Uri("template1");
  EXPECT_NE(FormatFindings(CheckDatabase(journal)).find("store-schema"), std::string::npos);
  journal.journal = "mysql:x";
  EXPECT_TRUE(AnyFailed(CheckDatabase(journal)));
}

}  // namespace
}  // namespace corbslam::services
