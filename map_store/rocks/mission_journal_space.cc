// Implements the part of MissionJournal that nobody waits for: it gives back disk and memory, and
// notes how far the mission is durable.
#include <filesystem>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "map_store/rocks/durable_mark.h"
#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/mission_journal.h"
#include "map_store/rocks/rocks_database.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Tables have bytes of their own, and what is deleted may come to little.
constexpr uint64_t kLittle = 8 << 20;
// What was written to lately will be written to again.
constexpr absl::Duration kUntilIdle = absl::Seconds(30);
constexpr uint64_t kLeastToFlush = 1 << 20;

}  // namespace

void MissionJournal::WriteMark() {
  if (options_.only_read || !Damage().ok()) return;
  absl::MutexLock marking(&marking_);
  Position synced = 0;
  {
    absl::MutexLock lock(&mutex_);
    synced = synced_;
  }
  if (closed_ || synced <= marked_) return;
  WriteDurableMark(database_->directory(), synced);
  marked_ = synced;
}

uint64_t MissionJournal::DiskBytes() const { return BytesIn(database_->directory()); }

bool MissionJournal::IsWasteful() const {
  uint64_t live = 0;
  {
    absl::MutexLock lock(&mutex_);
    if (!may_be_wasteful_) return false;
    live = contents_.live_bytes() + pictures_.bytes();
  }
  return DiskBytes() > live + live / 4 + kLittle;
}

void MissionJournal::SetMayBeWasteful(bool may_be) {
  absl::MutexLock lock(&mutex_);
  may_be_wasteful_ = may_be;
}

absl::Status MissionJournal::TidyMemory(absl::Time now) {
  {
    absl::MutexLock lock(&mutex_);
    if (looked_at_ != written_ || unchanged_since_ == absl::InfiniteFuture()) {
      looked_at_ = written_;
      unchanged_since_ = now;
    }
    if (now - unchanged_since_ < kUntilIdle) return absl::OkStatus();
  }
  if (database_->BytesInMemory() < kLeastToFlush) return absl::OkStatus();
  return ToStatus(database_->Flush());
}

absl::Status MissionJournal::CheckRoomToTidy() const {
  std::error_code error;
  const auto space = std::filesystem::space(options_.directory, error);
  absl::MutexLock lock(&mutex_);
  const uint64_t live = contents_.live_bytes() + pictures_.bytes();
  if (error || space.available >= live + kLittle) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("journal ", database_->directory(), ": tidying up takes ", live,
                   " bytes for a while, and the disk has ", space.available, " free"));
}

absl::Status MissionJournal::Tidy(absl::Time now) {
  if (!Damage().ok() || database_->failed()) return absl::OkStatus();
  WriteMark();
  RETURN_IF_ERROR(TidyMemory(now));
  return TidyDisk();
}

absl::Status MissionJournal::Settle() {
  if (!Damage().ok() || database_->failed()) return absl::OkStatus();
  RETURN_IF_ERROR(ToStatus(database_->Flush()));
  return TidyDisk();
}

absl::Status MissionJournal::TidyDisk() {
  if (!IsWasteful()) return absl::OkStatus();
  RETURN_IF_ERROR(CheckRoomToTidy());
  SetMayBeWasteful(false);
  const rocksdb::Status tidied = database_->Tidy();
  if (tidied.ok()) return absl::OkStatus();
  SetMayBeWasteful(true);
  return tidied.IsIncomplete() ? absl::OkStatus() : ToStatus(tidied);
}

}  // namespace corbslam::map_store
