// Moves batches, and what is in none yet, to the disk, and gives room back there.
#include <glog/logging.h>

#include <memory>
#include <optional>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client_agent/upload/upload_queue.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {

void UploadQueue::NoteSpool(const absl::Status& room) {
  const uint64_t syncs = spool_->syncs();
  absl::MutexLock lock(&mutex_);
  if (room.ok() != room_.ok()) {
    LOG(WARNING) << (room.ok() ? "the spool has room again" : room.ToString());
  }
  room_ = room;
  // The files have more: what is acknowledged goes with its file, and the local map in use stays.
  spool_bytes_ = outbox_.SpooledBytes();
  spool_syncs_ = syncs;
}

void UploadQueue::NoteDurable(const absl::Status& durable) {
  absl::MutexLock lock(&mutex_);
  if (durable.ok() != durable_.ok()) {
    LOG(WARNING) << (durable.ok()
                         ? "the spool takes what is mapped again"
                         : absl::StrCat("what is mapped now would not outlive the process, "
                                        "because the spool can't take it: ",
                                        durable.ToString()));
  }
  durable_ = durable;
}

void UploadQueue::ReleaseSpooled() {
  std::vector<SpooledBatch> released;
  {
    absl::MutexLock lock(&mutex_);
    released = outbox_.TakeReleased();
  }
  for (const SpooledBatch& spooled : released) spool_->Release(spooled);
}

void UploadQueue::TakeSyncError() {
  const absl::Status error = spool_->TakeSyncError();
  if (error.ok()) return;
  NoteDurable(error);
  const uint64_t synced = spool_->synced();
  for (auto& [id, writer] : held_back_) writer.Release(*spool_);
  held_back_lost_ = true;
  if (snapshot_.has_value() && !snapshot_->future.valid()) {
    for (const SpooledBatch& part : snapshot_->written) spool_->Release(part);
    snapshot_.reset();
  }
  absl::MutexLock lock(&mutex_);
  outbox_.MarkUnwritten(synced);
}

std::optional<uint64_t> UploadQueue::WriteHeldBack(const HeldBackItems& held_back) {
  uint64_t last = 0;
  {
    absl::MutexLock lock(&mutex_);
    if (outbox_.OldestUnwritten() != nullptr) return std::nullopt;
    last = outbox_.LastNumber(held_back.rest.local_map);
  }
  if (last == 0) return std::nullopt;
  const uint64_t before = spool_->appended_bytes();
  HeldBackWriter& writer = held_back_[held_back.rest.local_map];
  absl::Status written = writer.Write(held_back, last, *spool_);
  if (absl::IsResourceExhausted(written) && GiveUpAcknowledged()) {
    written = writer.Write(held_back, last, *spool_);
  }
  if (!written.ok()) {
    writer.Release(*spool_);
    NoteDurable(written);
    return std::nullopt;
  }
  return spool_->appended_bytes() - before;
}

void UploadQueue::ReleaseHeldBack(LocalMapId local_map) {
  const auto it = held_back_.find(local_map);
  if (it == held_back_.end()) return;
  WriteAll();
  bool all_written = false;
  {
    absl::MutexLock lock(&mutex_);
    all_written = outbox_.OldestUnwritten() == nullptr;
  }
  if (all_written) {
    it->second.Finish(*spool_);
  } else {
    // The disk takes no batch: room is worth more.
    it->second.Release(*spool_);
  }
  held_back_.erase(it);
}

bool UploadQueue::GiveUpAcknowledged() {
  {
    absl::MutexLock lock(&mutex_);
    if (outbox_.AcknowledgedBatches(in_use_).size() <= 1) return false;
    LOG(WARNING) << "the spool has no room left: what the map store has of local map "
                 << ToString(in_use_) << " leaves it, so that the map can't be resumed";
    outbox_.StopKeeping(in_use_);
  }
  ReleaseSpooled();
  return true;
}

// Returns false if there is nothing to write, or it can't be written.
bool UploadQueue::WriteOldest() {
  std::shared_ptr<const MapUpdateBatch> oldest;
  {
    absl::MutexLock lock(&mutex_);
    const Outbox::Entry* entry = outbox_.OldestUnwritten();
    if (entry != nullptr) oldest = entry->batch;
  }
  if (oldest == nullptr) {
    NoteDurable(absl::OkStatus());
    return false;
  }
  const absl::StatusOr<SpooledBatch> spooled = spool_->Append(*oldest);
  if (absl::IsResourceExhausted(spooled.status()) && GiveUpAcknowledged()) return true;
  if (!spooled.ok()) {
    NoteDurable(spooled.status());
    return false;
  }
  absl::MutexLock lock(&mutex_);
  outbox_.MarkWritten(*spooled);
  return true;
}

void UploadQueue::WriteAll() {
  if (!options_.write_all) return;
  TakeSyncError();
  while (WriteOldest()) {
  }
}

absl::Status UploadQueue::KeepOnDisk(const Outbox::Entry& entry) {
  if (entry.spooled.has_value()) {
    if (entry.spooled->order <= spool_->synced()) return absl::OkStatus();
    absl::Status synced = spool_->Sync();
    const uint64_t kept = spool_->synced();
    if (synced.ok() && entry.spooled->order <= kept) return synced;
    // An error that somebody else has taken.
    if (synced.ok()) synced = absl::UnavailableError("the disk did not keep the spool's file");
    absl::MutexLock lock(&mutex_);
    outbox_.MarkUnwritten(kept);
    return synced;
  }
  const absl::StatusOr<SpooledBatch> spooled = spool_->Append(*entry.batch);
  RETURN_IF_ERROR(spooled.status());
  if (absl::Status synced = spool_->Sync(); !synced.ok()) {
    spool_->Release(*spooled);
    return synced;
  }
  absl::MutexLock lock(&mutex_);
  outbox_.MarkWritten(*spooled);
  return absl::OkStatus();
}

// Returns false if there is nothing to move, or it can't be moved.
bool UploadQueue::SpillOldest(size_t allowed_bytes) {
  Outbox::Entry oldest;
  {
    absl::MutexLock lock(&mutex_);
    const Outbox::Entry* entry = outbox_.OldestInMemory();
    if (entry != nullptr && outbox_.bytes() > 0 && outbox_.bytes() >= allowed_bytes) {
      oldest = *entry;
    }
  }
  // Memory holds the batch until it is on the disk for certain.
  const absl::Status kept = oldest.batch == nullptr ? absl::OkStatus() : KeepOnDisk(oldest);
  NoteSpool(kept);
  if (oldest.batch == nullptr || !kept.ok()) return false;
  absl::MutexLock lock(&mutex_);
  outbox_.Evict(oldest.local_map, oldest.number);
  return true;
}

void UploadQueue::Spill() {
  if (spool_ == nullptr) return;
  ReleaseSpooled();
  WriteAll();
  if (options_.keep) KeepSnapshot();
  while (SpillOldest(options_.max_memory_bytes)) {
  }
}

bool UploadQueue::SpillAll() {
  if (spool_ == nullptr) return false;
  ReleaseSpooled();
  WriteAll();
  while (SpillOldest(0)) {
  }
  absl::MutexLock lock(&mutex_);
  return outbox_.bytes() == 0;
}

}  // namespace corbslam::client_agent
