// Makes room in the spool: a snapshot of a local map is written in place of its acknowledged
// batches.
#include <glog/logging.h>

#include <chrono>
#include <future>
#include <map>
#include <utility>

#include "client_agent/upload/spooled_map_reading.h"
#include "client_agent/upload/upload_queue.h"
#include "slam/util/named_thread.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

using Kind = SpoolRecord::Kind;

absl::StatusOr<std::vector<MapUpdateBatch>> MakeSnapshot(
    LocalMapId local_map, const std::vector<SpooledBatch>& acknowledged, const ReadSpooled& read) {
  ASSIGN_OR_RETURN(const SpooledMap map, ReadSpooledMap(local_map, acknowledged, read));
  return map.ToBatches();
}

}  // namespace

absl::StatusOr<SpooledMap> UploadQueue::ReadLocalMap(LocalMapId local_map) {
  std::vector<SpooledBatch> records;
  std::map<uint64_t, std::shared_ptr<const MapUpdateBatch>> in_memory;
  {
    absl::MutexLock lock(&mutex_);
    records = outbox_.AcknowledgedBatches(local_map);
    for (const Outbox::Entry& entry : outbox_.EntriesOf(local_map)) {
      SpooledBatch record;
      record.record.local_map = local_map;
      record.record.number = entry.number;
      if (entry.batch != nullptr) in_memory[entry.number] = entry.batch;
      records.push_back(entry.spooled.value_or(record));
    }
  }
  return ReadSpooledMap(local_map, records,
                        [&](const SpooledBatch& spooled) -> absl::StatusOr<MapUpdateBatch> {
                          const auto batch = in_memory.find(spooled.record.number);
                          if (batch != in_memory.end() && spooled.record.kind == Kind::kBatch) {
                            return *batch->second;
                          }
                          return spool_->Read(spooled);
                        });
}

void UploadQueue::BeginSnapshot() {
  MakingSnapshot making;
  std::vector<SpooledBatch> acknowledged;
  {
    absl::MutexLock lock(&mutex_);
    making.local_map = in_use_;
    acknowledged = outbox_.AcknowledgedBatches(in_use_);
  }
  uint64_t bytes = 0;
  for (const SpooledBatch& spooled : acknowledged) {
    bytes += spooled.record.bytes;
    if (spooled.record.kind == Kind::kBatch) making.number = spooled.record.number;
  }
  if (making.number == 0 || bytes <= 2 * snapshot_bytes_ + options_.snapshot_after_bytes) return;
  auto make = [local_map = making.local_map, acknowledged = std::move(acknowledged),
               spool = spool_.get()] {
    return MakeSnapshot(local_map, acknowledged,
                        [spool](const SpooledBatch& spooled) { return spool->Read(spooled); });
  };
  making.future = options_.snapshot_at_once ? std::async(std::launch::deferred, std::move(make))
                                            : StartAsync("spool snapshot", std::move(make));
  snapshot_ = std::move(making);
}

void UploadQueue::WriteSnapshot(Snapshot snapshot) {
  if (!snapshot.ok()) {
    // The next process would find the same.
    LOG(WARNING) << "local map " << ToString(snapshot_->local_map)
                 << " can't be written as a whole: " << snapshot.status();
    snapshot_bytes_ = spool_->bytes();
    snapshot_.reset();
    return;
  }
  snapshot_bytes_ = 0;
  for (size_t i = 0; i < snapshot->size(); ++i) {
    (*snapshot)[i].number = snapshot_->number;
    const Kind kind = i + 1 == snapshot->size() ? Kind::kSnapshotEnd : Kind::kSnapshotPart;
    const absl::StatusOr<SpooledBatch> written = spool_->Append((*snapshot)[i], kind);
    if (!written.ok()) {
      for (const SpooledBatch& part : snapshot_->written) spool_->Release(part);
      NoteDurable(written.status());
      snapshot_bytes_ = spool_->bytes();
      snapshot_.reset();
      return;
    }
    snapshot_->written.push_back(*written);
    snapshot_bytes_ += written->record.bytes;
  }
}

void UploadQueue::KeepSnapshot() {
  if (!snapshot_.has_value()) BeginSnapshot();
  if (!snapshot_.has_value()) return;
  if (snapshot_->future.valid()) {
    const bool is_ready =
        options_.snapshot_at_once ||
        snapshot_->future.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    if (!is_ready) return;
    WriteSnapshot(snapshot_->future.get());
    if (!snapshot_.has_value()) return;
  }
  // The batches that it stands for go when it is on the disk for certain.
  if (snapshot_->written.back().order > spool_->synced()) {
    spool_->HurrySync();
    if (snapshot_->written.back().order > spool_->synced()) return;
  }
  {
    absl::MutexLock lock(&mutex_);
    outbox_.ReplaceAcknowledged(snapshot_->local_map, snapshot_->written);
  }
  snapshot_.reset();
  ReleaseSpooled();
}

}  // namespace corbslam::client_agent
