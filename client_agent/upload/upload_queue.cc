#include "client_agent/upload/upload_queue.h"

#include <glog/logging.h>

#include <algorithm>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"

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
    return found.record.kind == SpoolRecord::Kind::kSnapshotPart ||
           found.record.kind == SpoolRecord::Kind::kSnapshotEnd;
  });
  for (const SpooledBatch& found : in_order) {
    const SpoolRecord::Kind kind = found.record.kind;
    // TellHeldBack has made batches of what is still of use.
    if (kind == SpoolRecord::Kind::kHeldBackKeyframe || kind == SpoolRecord::Kind::kHeldBackRest) {
      spool_->Release(found);
      continue;
    }
    const absl::Status added = outbox_.AddFound(found);
    if (added.ok() || !cut.insert(found.record.local_map).second) continue;
    NoteLoss({found.record.local_map, /*of_earlier_process=*/true, added});
  }
  spool_bytes_ = outbox_.SpooledBytes();
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

bool UploadQueue::HasBegun(LocalMapId local_map) const {
  absl::MutexLock lock(&mutex_);
  return outbox_.LastNumber(local_map) > 0;
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
