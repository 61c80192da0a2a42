#include "client_agent/upload/upload_queue.h"

#include <glog/logging.h>

#include <algorithm>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {

UploadQueue::UploadQueue(const UploadQueueOptions& options, std::unique_ptr<Spool> spool)
    : options_(options),
      spool_(std::move(spool)),
      outbox_(options.max_memory_bytes, /*marks_open=*/options.write_all) {
  if (spool_ == nullptr) return;
  absl::MutexLock lock(&mutex_);
  std::set<LocalMapId> cut;
  std::vector<SpooledBatch> in_order = spool_->TakeFound();
  // What stands for earlier batches may have been written after later ones.
  std::stable_partition(in_order.begin(), in_order.end(), [](const SpooledBatch& found) {
    return found.record.kind == SpoolRecord::Kind::kWholePart ||
           found.record.kind == SpoolRecord::Kind::kWholeEnd;
  });
  for (const SpooledBatch& found : in_order) {
    const SpoolRecord::Kind kind = found.record.kind;
    // TellHeld has made batches of what is still of use.
    if (kind == SpoolRecord::Kind::kHeldKeyframe || kind == SpoolRecord::Kind::kHeldRest) {
      spool_->Release(found);
      continue;
    }
    const absl::Status added = outbox_.AddFound(found);
    if (added.ok() || !cut.insert(found.record.local_map).second) continue;
    NoteLoss({found.record.local_map, /*of_earlier_process=*/true, added});
  }
  spool_bytes_ = spool_->bytes();
  if (options.goes_on.IsValid() && !outbox_.GoOnWith(options.goes_on)) {
    LOG(WARNING) << "local map " << ToString(options.goes_on) << " can't go on";
  }
}

bool UploadQueue::Begin(LocalMapId local_map) {
  absl::MutexLock lock(&mutex_);
  if (in_use_.IsValid()) outbox_.StopKeeping(in_use_);
  const bool goes_on = local_map == options_.goes_on && !in_use_.IsValid();
  in_use_ = local_map;
  if (goes_on || outbox_.Begin(local_map)) {
    if (options_.keep) outbox_.Keep(local_map);
    return true;
  }
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

bool UploadQueue::IsOnDisk() const {
  absl::MutexLock lock(&mutex_);
  return outbox_.bytes() == 0;
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
  status.spool_syncs = spool_syncs_;
  status.durable = durable_;
  status.room = room_;
  if (status.room.ok() && !outbox_.HasRoom()) {
    status.room = absl::ResourceExhaustedError(absl::StrCat(
        "the outbox has ", outbox_.bytes(), " bytes; the limit is ", options_.max_memory_bytes));
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
  const uint64_t syncs = spool_->syncs();
  absl::MutexLock lock(&mutex_);
  if (room.ok() != room_.ok()) {
    LOG(WARNING) << (room.ok() ? "the spool has room again" : room.ToString());
  }
  room_ = room;
  spool_bytes_ = bytes;
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
  for (auto& [id, writer] : held_) writer.Release(*spool_);
  held_lost_ = true;
  if (whole_.has_value() && !whole_->future.valid()) {
    for (const SpooledBatch& part : whole_->written) spool_->Release(part);
    whole_.reset();
  }
  absl::MutexLock lock(&mutex_);
  outbox_.MarkUnwritten(synced);
}

bool UploadQueue::HasBegun(LocalMapId local_map) const {
  absl::MutexLock lock(&mutex_);
  return outbox_.LastNumber(local_map) > 0;
}

std::optional<uint64_t> UploadQueue::WriteHeld(const HeldItems& held) {
  uint64_t last = 0;
  {
    absl::MutexLock lock(&mutex_);
    if (outbox_.OldestUnwritten() != nullptr) return std::nullopt;
    last = outbox_.LastNumber(held.rest.local_map);
  }
  if (last == 0) return std::nullopt;
  const uint64_t before = spool_->appended_bytes();
  HeldWriter& writer = held_[held.rest.local_map];
  absl::Status written = writer.Write(held, last, *spool_);
  if (absl::IsResourceExhausted(written) && GiveUpKept()) {
    written = writer.Write(held, last, *spool_);
  }
  if (!written.ok()) {
    writer.Release(*spool_);
    NoteDurable(written);
    return std::nullopt;
  }
  return spool_->appended_bytes() - before;
}

void UploadQueue::ReleaseHeld(LocalMapId local_map) {
  const auto it = held_.find(local_map);
  if (it == held_.end()) return;
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
  held_.erase(it);
}

bool UploadQueue::GiveUpKept() {
  {
    absl::MutexLock lock(&mutex_);
    if (outbox_.Kept(in_use_).size() <= 1) return false;
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
  if (absl::IsResourceExhausted(spooled.status()) && GiveUpKept()) return true;
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
  if (options_.keep) KeepWhole();
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

// A store that had a batch which a loss of power took from the disk could not be gone on with.
bool UploadQueue::MaySend(const Outbox::Entry& entry) const {
  if (!options_.keep || spool_ == nullptr) return true;
  if (!entry.spooled.has_value()) {
    absl::MutexLock lock(&mutex_);
    // The disk has no room; the store should not wait for that.
    return !durable_.ok();
  }
  if (entry.spooled->order <= spool_->synced()) return true;
  spool_->HurrySync();
  return entry.spooled->order <= spool_->synced();
}

std::shared_ptr<const MapUpdateBatch> UploadQueue::TakeUnsent(std::vector<LostLocalMap>& lost) {
  while (true) {
    Outbox::Entry entry;
    {
      absl::MutexLock lock(&mutex_);
      const Outbox::Entry* next = outbox_.NextUnsent();
      if (next == nullptr) return nullptr;
      entry = *next;
    }
    if (!MaySend(entry)) return nullptr;
    {
      absl::MutexLock lock(&mutex_);
      const Outbox::Entry* next = outbox_.NextUnsent();
      if (next == nullptr || next->local_map != entry.local_map || next->number != entry.number) {
        continue;
      }
      entry = *next;
      // The entry is marked before it is sent, because the answer may come from inside the call.
      outbox_.MarkSent();
    }
    if (entry.batch != nullptr) return entry.batch;
    absl::StatusOr<MapUpdateBatch> read = spool_->Read(*entry.spooled);
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
