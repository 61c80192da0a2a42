// Tests which journals flags may ask for, and what is said of others.
#include "services/programs/store_journal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

std::string Wrong(const JournalFlags& flags) {
  const absl::Status status = CheckJournalFlags(flags);
  EXPECT_TRUE(status.ok() || absl::IsInvalidArgument(status)) << status;
  return std::string(status.message());
}

TEST(StoreJournalTest, ADatabaseIsNamedByAUriWithoutSecrets) {
  for (const char* journal :
       {"postgres:postgresql://corbslam@db1:5432/x", "postgres://corbslam@db1:5432/x",
        "postgres:host=db1 port=5432 dbname=x user=corbslam"}) {
    EXPECT_EQ(Wrong({.journal = journal}), "") << journal;
    EXPECT_EQ(DescribeJournal({.journal = journal}), "postgres db1:5432/x") << journal;
  }
  EXPECT_THAT(Wrong({.journal = "postgres://db1/x", .lease_s = 1}), HasSubstr("at least 3"));
  EXPECT_THAT(Wrong({.journal = "mysql://db1/x"}), HasSubstr("--journal must be postgres:URI"));
  EXPECT_THAT(Wrong({.journal = "postgres:host=db1 sslmod=require"}), HasSubstr("sslmod"));
  const std::string secret = Wrong({.journal = "postgres://corbslam:hush@db1/x"});
  EXPECT_THAT(secret, HasSubstr("--journal-password-file"));
  EXPECT_THAT(secret, ::testing::Not(HasSubstr("hush")));
}

TEST(StoreJournalTest, AStoreHasOneJournal) {
  const std::string folder = ::testing::TempDir();
  EXPECT_EQ(Wrong({.data_dir = folder}), "");
  EXPECT_THAT(Wrong({.data_dir = folder, .journal = "postgres://db1/x"}), HasSubstr("exclude"));
  EXPECT_THAT(Wrong({.data_dir = folder, .password_file = "p"}), HasSubstr("without --journal"));
  EXPECT_EQ(DescribeJournal({}), "memory alone");
}

TEST(StoreJournalTest, AFolderAndMemoryAreOpenedAsEver) {
  auto memory = OpenJournal({}, 0);
  ASSERT_TRUE(memory.ok()) << memory.status();
  EXPECT_EQ(memory->rocks, nullptr);
  auto folder = OpenJournal({.data_dir = ::testing::TempDir() + "/store_journal"}, 0);
  ASSERT_TRUE(folder.ok()) << folder.status();
  EXPECT_EQ(folder->rocks, folder->journal.get());
  const auto nowhere = OpenJournal({.journal = "postgres://127.0.0.1:1/x"}, 0);
  EXPECT_TRUE(absl::IsUnavailable(nowhere.status())) << nowhere.status();
}

}  // namespace
}  // namespace corbslam::services
