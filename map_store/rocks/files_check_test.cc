#include "map_store/rocks/files_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rocksdb/db.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

bool All(uint64_t) { return true; }

// A database whose log has records of one fragment and of several.
class FilesCheckTest : public ::testing::Test {
 protected:
  FilesCheckTest() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    Open();
    for (int i = 0; i < 40; ++i) Write(absl::StrCat("a", i), i % 8 == 0 ? 50'000 : 300);
  }
  ~FilesCheckTest() override {
    db_.reset();
    fs::remove_all(folder_);
  }

  void Open() {
    rocksdb::Options options;
    options.create_if_missing = true;
    options.allow_fallocate = false;
    rocksdb::DB* opened = nullptr;
    const rocksdb::Status status = rocksdb::DB::Open(options, folder_.string(), &opened);
    ASSERT_TRUE(status.ok()) << status.ToString();
    db_.reset(opened);
  }
  void Write(const std::string& key, size_t bytes) {
    const rocksdb::Status written =
        db_->Put(rocksdb::WriteOptions(), key, std::string(bytes, static_cast<char>(key.back())));
    ASSERT_TRUE(written.ok()) << written.ToString();
  }
  // Returns the newest file whose name has this in it.
  fs::path Find(const std::string& part) const {
    fs::path found;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      const std::string name = entry.path().filename().string();
      if (absl::StrContains(name, part) && entry.path() > found) found = entry.path();
    }
    return found;
  }
  static void Flip(const fs::path& file, uint64_t at) {
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    stream.seekg(static_cast<std::streamoff>(at));
    const int byte = stream.get();
    stream.seekp(static_cast<std::streamoff>(at));
    stream.put(static_cast<char>(byte ^ 0x40));
  }
  FilesCheck Closed() { return CheckClosedFiles(folder_.string()); }

  const fs::path folder_ = fs::path(::testing::TempDir()) / "files_check_test" /
                           ::testing::UnitTest::GetInstance()->current_test_info()->name();
  std::unique_ptr<rocksdb::DB> db_;
};

TEST_F(FilesCheckTest, WholeFilesAreFoundWhole) {
  const auto log = CheckLogFile(Find(".log").string());
  ASSERT_TRUE(log.ok()) << log.status();
  EXPECT_EQ(log->problem, "");
  EXPECT_EQ(log->intact_bytes, fs::file_size(Find(".log")));
  EXPECT_EQ(log->last_sequence, db_->GetLatestSequenceNumber());
  EXPECT_EQ(CheckLogFile(Find("MANIFEST").string())->problem, "");
  EXPECT_TRUE(CheckLiveFiles(*db_, All).ok()) << CheckLiveFiles(*db_, All);
  ASSERT_TRUE(db_->Flush(rocksdb::FlushOptions()).ok());
  EXPECT_TRUE(CheckLiveFiles(*db_, All).ok()) << CheckLiveFiles(*db_, All);
  db_.reset();
  EXPECT_THAT(Closed().damaged, IsEmpty());
  EXPECT_THAT(Closed().torn, IsEmpty());
  EXPECT_THAT(Closed().notes, IsEmpty());
}

TEST_F(FilesCheckTest, NoTurnedBitOfALogPasses) {
  db_.reset();
  const fs::path log = Find(".log");
  const uint64_t size = fs::file_size(log);
  std::mt19937_64 random(5);
  for (int i = 0; i < 200; ++i) {
    const uint64_t at = random() % size;
    Flip(log, at);
    const auto checked = CheckLogFile(log.string());
    ASSERT_TRUE(checked.ok()) << checked.status();
    // What is left of a block that has no room for a record says nothing.
    EXPECT_TRUE(!checked->problem.empty() || at % (32 << 10) > (32 << 10) - 8) << at;
    EXPECT_LE(checked->intact_bytes, size);
    Flip(log, at);
  }
}

TEST_F(FilesCheckTest, ALogThatEndsEarlyMayBeTorn) {
  db_.reset();
  const fs::path log = Find(".log");
  std::mt19937_64 random(6);
  while (fs::file_size(log) > 6000) {
    fs::resize_file(log, fs::file_size(log) - 1 - random() % 5000);
    const auto checked = CheckLogFile(log.string());
    ASSERT_TRUE(checked.ok()) << checked.status();
    EXPECT_TRUE(checked->problem.empty() || checked->may_be_torn) << checked->problem;
    EXPECT_EQ(checked->problem.empty(), checked->intact_bytes == fs::file_size(log));
  }
  EXPECT_THAT(Closed().damaged, IsEmpty());
}

TEST_F(FilesCheckTest, DamageOfAnOpenDatabasesLogIsFound) {
  Flip(Find(".log"), 100);
  const absl::Status damaged = CheckLiveFiles(*db_, All);
  EXPECT_TRUE(absl::IsDataLoss(damaged)) << damaged;
  EXPECT_THAT(std::string(damaged.message()), HasSubstr(Find(".log").string()));
  Flip(Find(".log"), 100);
  EXPECT_TRUE(CheckLiveFiles(*db_, All).ok());
  fs::resize_file(Find(".log"), fs::file_size(Find(".log")) / 2);
  EXPECT_TRUE(absl::IsDataLoss(CheckLiveFiles(*db_, All))) << "what was written is not there";
  ASSERT_TRUE(db_->Flush(rocksdb::FlushOptions()).ok());
  EXPECT_TRUE(CheckLiveFiles(*db_, All).ok()) << "tables have it all, and another log has begun";
}

TEST_F(FilesCheckTest, DamageOfTheListOfFilesIsFound) {
  const fs::path list = Find("MANIFEST");
  Flip(list, 12);
  absl::Status damaged = CheckLiveFiles(*db_, All);
  EXPECT_TRUE(absl::IsDataLoss(damaged)) << damaged;
  EXPECT_THAT(std::string(damaged.message()), HasSubstr(list.string()));
  Flip(list, 12);
  const fs::path current = folder_ / "CURRENT";
  Flip(current, 3);
  damaged = CheckLiveFiles(*db_, All);
  EXPECT_TRUE(absl::IsDataLoss(damaged)) << damaged;
  EXPECT_THAT(std::string(damaged.message()), HasSubstr(current.string()));
  EXPECT_THAT(std::string(Closed().status().message()), HasSubstr(current.string()));
  fs::remove(current);
  EXPECT_THAT(std::string(Closed().status().message()), HasSubstr("CURRENT is lost"));
}

TEST_F(FilesCheckTest, WhatLosesNothingIsNoted) {
  db_.reset();
  fs::remove(Find("OPTIONS"));
  std::ofstream(folder_ / "SUMMARY") << "none";
  std::ofstream(folder_ / "DURABLE") << "none";
  const FilesCheck found = Closed();
  EXPECT_TRUE(found.status().ok()) << found.status();
  EXPECT_EQ(found.notes.size(), 3u);
}

TEST_F(FilesCheckTest, ReadsNoFasterThanItIsTold) {
  int pieces = 0;
  const auto some = CheckLogFile(Find(".log").string(), ~uint64_t{0}, [&](uint64_t bytes) {
    EXPECT_LE(bytes, 256u << 10);
    return ++pieces < 1;
  });
  EXPECT_TRUE(absl::IsCancelled(some.status())) << some.status();
}

}  // namespace
}  // namespace corbslam::map_store
