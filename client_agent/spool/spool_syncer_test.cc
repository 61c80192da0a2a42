#include "client_agent/spool/spool_syncer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "absl/synchronization/notification.h"

namespace corbslam::client_agent {
namespace {

// Files of which only syncing is of interest. It may be held up, and may fail.
class SyncedFiles : public SpoolFiles {
 public:
  absl::StatusOr<std::vector<std::string>> List() override { return std::vector<std::string>(); }
  absl::StatusOr<uint64_t> Size(const std::string&) override { return 0; }
  absl::StatusOr<std::string> Read(const std::string&, uint64_t, size_t) override { return ""; }
  absl::Status Append(const std::string&, absl::string_view) override { return absl::OkStatus(); }
  absl::Status Truncate(const std::string&, uint64_t) override { return absl::OkStatus(); }
  absl::Status Remove(const std::string&) override { return absl::OkStatus(); }
  absl::Status Sync(const std::string& name) override {
    if (began != nullptr) began->Notify();
    if (may_go_on != nullptr) may_go_on->WaitForNotification();
    absl::MutexLock lock(&mutex);
    if (error.ok()) synced.push_back(name);
    return error;
  }

  absl::Notification* began = nullptr;
  absl::Notification* may_go_on = nullptr;
  absl::Mutex mutex;
  std::vector<std::string> synced ABSL_GUARDED_BY(mutex);
  absl::Status error ABSL_GUARDED_BY(mutex);
};

// Nothing is due but what somebody waits for.
constexpr SyncPolicy kLazy = {.after = absl::Hours(1), .bytes = uint64_t{1} << 40};

TEST(SpoolSyncerTest, SyncsAllFilesThatWereWritten) {
  SyncedFiles files;
  SpoolSyncer syncer(&files, kLazy);
  EXPECT_TRUE(syncer.SyncNow().ok()) << "there is nothing to sync";
  syncer.NoteWrite("a", 1, 10);
  syncer.NoteWrite("b", 2, 10);
  EXPECT_EQ(syncer.synced(), 0u);
  EXPECT_TRUE(syncer.SyncNow().ok());
  EXPECT_EQ(syncer.synced(), 2u);
  absl::MutexLock lock(&files.mutex);
  EXPECT_EQ(files.synced, (std::vector<std::string>{"a", "b"}));
}

TEST(SpoolSyncerTest, ManyBytesDoNotWait) {
  SyncedFiles files;
  absl::Notification began;
  files.began = &began;
  SpoolSyncer syncer(&files, {.after = absl::Hours(1), .bytes = 100});
  syncer.NoteWrite("a", 1, 100);
  began.WaitForNotification();
}

TEST(SpoolSyncerTest, OldBytesDoNotWait) {
  SyncedFiles files;
  absl::Notification began;
  files.began = &began;
  SpoolSyncer syncer(&files, {.after = absl::Milliseconds(1), .bytes = uint64_t{1} << 40});
  syncer.NoteWrite("a", 1, 1);
  began.WaitForNotification();
}

TEST(SpoolSyncerTest, WhatFailsIsSaidOnceAndNothingIsSyncedBefore) {
  SyncedFiles files;
  SpoolSyncer syncer(&files, kLazy);
  syncer.NoteWrite("a", 1, 1);
  ASSERT_TRUE(syncer.SyncNow().ok());
  {
    absl::MutexLock lock(&files.mutex);
    files.error = absl::UnavailableError("broken");
  }
  syncer.NoteWrite("a", 2, 1);
  EXPECT_TRUE(absl::IsUnavailable(syncer.SyncNow()));
  EXPECT_TRUE(syncer.TakeError().ok()) << "SyncNow has taken it";
  EXPECT_EQ(syncer.synced(), 1u);
  {
    absl::MutexLock lock(&files.mutex);
    files.error = absl::OkStatus();
  }
  syncer.NoteWrite("b", 3, 1);
  EXPECT_TRUE(syncer.SyncNow().ok());
  EXPECT_EQ(syncer.synced(), 3u);
}

// The disk says that it does not know a file that is gone, which is no failure.
TEST(SpoolSyncerTest, AFileThatGoesMeanwhileIsNoFailure) {
  SyncedFiles files;
  absl::Notification began;
  absl::Notification may_go_on;
  files.began = &began;
  files.may_go_on = &may_go_on;
  {
    absl::MutexLock lock(&files.mutex);
    files.error = absl::UnavailableError("no such file");
  }
  SpoolSyncer syncer(&files, kLazy);
  syncer.NoteWrite("a", 1, 1);
  syncer.Hurry();
  began.WaitForNotification();
  syncer.Forget("a");
  files.began = nullptr;
  may_go_on.Notify();
  EXPECT_TRUE(syncer.SyncNow().ok());
  EXPECT_EQ(syncer.synced(), 1u);
}

}  // namespace
}  // namespace corbslam::client_agent
