#include "client_agent/upload/upload_queue.h"

#include <glog/logging.h>

#include <set>
#include <utility>

#include "absl/strings/str_cat.h"

namespace corbslam::client_agent {

UploadQueue::UploadQueue(size_t max_memory_bytes, std::unique_ptr<Spool> spool)
    : max_memory_bytes_(max_memory_bytes), spool_(std::move(spool)), outbox_(max_memory_bytes) {
  if (spool_ == nullptr) return;
  absl::MutexLock lock(&mutex_);
  std::set<LocalMapId> cut;
  for (const SpooledBatch& found : spool_->TakeFound()) {
    const absl::Status added = outbox_.AddFound(found);
    if (added.ok() || !cut.insert(found.record.local_map).second) continue;
    NoteLoss({found.record.local_map, /*of_earlier_process=*/true, added});
  }
  spool_bytes_ = spool_->bytes();
}

bool UploadQueue::Begin(LocalMapId local_map) {
  absl::MutexLock lock(&mutex_);
  if (outbox_.Begin(local_map)) return true;
  NoteLoss({local_map, /*of_earlier_process=*/false,
            absl::AlreadyExistsError(absl::StrCat("an earlier process left batches of a local map ",
                                                  ToString(local_map)))});
  return false;
}

void UploadQueue::Push(MapUpdateBatch batch) {
  absl::MutexLock lock(&mutex_);
  outbox_.Push(std::move(batch));
}

void UploadQueue::Acknowledge(const Acknowledgement& acknowledgement) {
  absl::MutexLock lock(&mutex_);
  outbox_.Acknowledge(acknowledgement);
}

std::vector<LostLocalMap> UploadQueue::Resume(const SessionGrant& grant) {
  absl::MutexLock lock(&mutex_);
  std::vector<LostLocalMap> lost = outbox_.Resume(grant);
  if (std::optional<LostLocalMap> refused = GiveUpSuspect()) lost.push_back(*std::move(refused));
  for (const LostLocalMap& local_map : lost) NoteLoss(local_map);
  return lost;
}

std::optional<LostLocalMap> UploadQueue::GiveUpSuspect() {
  const std::optional<Suspect> suspect = std::exchange(suspect_, std::nullopt);
  const Outbox::Entry* oldest = outbox_.NextUnsent();
  if (!suspect.has_value() || oldest == nullptr || oldest->local_map != suspect->local_map ||
      oldest->number != suspect->number) {
    return std::nullopt;
  }
  outbox_.Drop(suspect->local_map);
  return LostLocalMap{suspect->local_map, /*of_earlier_process=*/false,
                      absl::DataLossError(absl::StrCat(
                          "the map store refuses batch ", suspect->number, " of local map ",
                          ToString(suspect->local_map), " for good: ", suspect->reason.message()))};
}

bool UploadQueue::NoteRefusal(const absl::Status& reason) {
  if (GiveUpEarlier(reason)) return true;
  absl::MutexLock lock(&mutex_);
  const Outbox::Entry* oldest = outbox_.OldestSent();
  if (oldest == nullptr) return false;
  suspect_ = Suspect{oldest->local_map, oldest->number, reason};
  return true;
}

bool UploadQueue::GiveUpEarlier(const absl::Status& reason) {
  absl::MutexLock lock(&mutex_);
  const std::optional<LocalMapId> oldest = outbox_.OldestLocalMap();
  if (!oldest.has_value() || !outbox_.IsOfEarlierProcess(*oldest)) return false;
  outbox_.Drop(*oldest);
  NoteLoss({*oldest, /*of_earlier_process=*/true,
            absl::DataLossError(absl::StrCat("the map store refuses what an earlier process left: ",
                                             reason.message()))});
  return true;
}

bool UploadQueue::HasRoom() const {
  absl::MutexLock lock(&mutex_);
  return outbox_.HasRoom();
}

bool UploadQueue::IsEmpty() const {
  absl::MutexLock lock(&mutex_);
  return outbox_.IsEmpty();
}

bool UploadQueue::HasUnsent() const {
  absl::MutexLock lock(&mutex_);
  return outbox_.NextUnsent() != nullptr;
}

std::vector<LocalMapId> UploadQueue::local_maps() const {
  absl::MutexLock lock(&mutex_);
  return outbox_.local_maps();
}

UploadStatus UploadQueue::status() const {
  absl::MutexLock lock(&mutex_);
  UploadStatus status;
  status.batches = outbox_.size();
  status.memory_bytes = outbox_.bytes();
  status.spool_bytes = spool_bytes_;
  status.room = room_;
  if (status.room.ok() && !outbox_.HasRoom()) {
    status.room = absl::ResourceExhaustedError(absl::StrCat(
        "the outbox has ", outbox_.bytes(), " bytes; the limit is ", max_memory_bytes_));
  }
  status.loss = loss_;
  status.lost_local_maps = lost_local_maps_;
  return status;
}

void UploadQueue::MarkUnsent() {
  absl::MutexLock lock(&mutex_);
  outbox_.MarkUnsent();
}

void UploadQueue::NoteLoss(const LostLocalMap& lost) {
  LOG(ERROR) << "local map " << ToString(lost.id) << " is given up: " << lost.reason;
  loss_ = lost.reason;
  ++lost_local_maps_;
}

void UploadQueue::NoteSpool(const absl::Status& room) {
  const uint64_t bytes = spool_->bytes();
  absl::MutexLock lock(&mutex_);
  if (room.ok() != room_.ok()) {
    LOG(WARNING) << (room.ok() ? "the spool has room again" : room.ToString());
  }
  room_ = room;
  spool_bytes_ = bytes;
}

void UploadQueue::ReleaseSpooled() {
  std::vector<SpooledBatch> released;
  {
    absl::MutexLock lock(&mutex_);
    released = outbox_.TakeReleased();
  }
  for (const SpooledBatch& spooled : released) spool_->Release(spooled);
}

// Returns false if there is nothing to move, or it can't be moved.
bool UploadQueue::SpillOldest(size_t allowed_bytes) {
  std::shared_ptr<const MapUpdateBatch> oldest;
  {
    absl::MutexLock lock(&mutex_);
    if (outbox_.bytes() > 0 && outbox_.bytes() >= allowed_bytes) oldest = outbox_.OldestInMemory();
  }
  if (oldest == nullptr) {
    NoteSpool(absl::OkStatus());
    return false;
  }
  const absl::StatusOr<SpooledBatch> spooled = spool_->Append(*oldest);
  // Memory holds the batch until it is on the disk for certain.
  const absl::Status kept = spooled.ok() ? spool_->Sync() : spooled.status();
  NoteSpool(kept);
  if (!kept.ok()) {
    if (spooled.ok()) spool_->Release(*spooled);
    return false;
  }
  absl::MutexLock lock(&mutex_);
  outbox_.MarkSpilled(*spooled);
  return true;
}

void UploadQueue::Spill() {
  if (spool_ == nullptr) return;
  ReleaseSpooled();
  while (SpillOldest(max_memory_bytes_)) {
  }
}

void UploadQueue::SpillAll() {
  if (spool_ == nullptr) return;
  ReleaseSpooled();
  while (SpillOldest(0)) {
  }
}

std::shared_ptr<const MapUpdateBatch> UploadQueue::TakeUnsent(std::vector<LostLocalMap>& lost) {
  while (true) {
    Outbox::Entry entry;
    {
      absl::MutexLock lock(&mutex_);
      const Outbox::Entry* next = outbox_.NextUnsent();
      if (next == nullptr) return nullptr;
      entry = *next;
      // The entry is marked before it is sent, because the answer may come from inside the call.
      outbox_.MarkSent();
    }
    if (entry.batch != nullptr) return entry.batch;
    absl::StatusOr<MapUpdateBatch> read = spool_->Read(entry.spooled);
    if (read.ok()) return std::make_shared<const MapUpdateBatch>(*std::move(read));
    absl::MutexLock lock(&mutex_);
    if (!absl::IsDataLoss(read.status())) {
      // The disk may answer again.
      outbox_.MarkUnsent();
      room_ = read.status();
      return nullptr;
    }
    lost.push_back({entry.local_map, outbox_.IsOfEarlierProcess(entry.local_map), read.status()});
    outbox_.Drop(entry.local_map);
    NoteLoss(lost.back());
  }
}

}  // namespace corbslam::client_agent
