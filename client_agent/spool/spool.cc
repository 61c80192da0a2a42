#include "client_agent/spool/spool.h"

#include <glog/logging.h>

#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/strip.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr char kSuffix[] = ".spool";

std::string NameOf(uint64_t segment) { return absl::StrFormat("%012d%s", segment, kSuffix); }

// Returns 0 for what is not the name of a segment.
uint64_t NumberOf(absl::string_view name) {
  uint64_t number = 0;
  if (!absl::ConsumeSuffix(&name, kSuffix) || !absl::SimpleAtoi(name, &number)) return 0;
  return NameOf(number) == absl::StrCat(name, kSuffix) ? number : 0;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Spool>> Spool::Open(const SpoolOptions& options,
                                                   std::unique_ptr<SpoolFiles> files,
                                                   BatchCodec codec) {
  std::unique_ptr<Spool> spool(new Spool(options, std::move(files), std::move(codec)));
  RETURN_IF_ERROR(spool->Recover());
  if (options.sync.has_value()) {
    RETURN_IF_ERROR(spool->SyncFound());
    spool->syncer_ = std::make_unique<SpoolSyncer>(spool->files_.get(), *options.sync);
  }
  return spool;
}

Spool::Spool(const SpoolOptions& options, std::unique_ptr<SpoolFiles> files, BatchCodec codec)
    : options_(options), files_(std::move(files)), codec_(std::move(codec)) {}

absl::Status Spool::Recover() {
  ASSIGN_OR_RETURN(const std::vector<std::string> names, files_->List());
  for (const std::string& name : names) {
    if (NumberOf(name) != 0) RETURN_IF_ERROR(RecoverSegment(name));
  }
  if (!found_.empty()) {
    LOG(INFO) << "an earlier process left " << found_.size() << " batches in the spool";
  }
  return absl::OkStatus();
}

absl::Status Spool::RecoverSegment(const std::string& name) {
  ASSIGN_OR_RETURN(const uint64_t size, files_->Size(name));
  ASSIGN_OR_RETURN(const SegmentContents contents, ScanSegment(*files_, name, options_.owner));
  const uint64_t number = NumberOf(name);
  next_segment_ = number + 1;
  if (contents.torn_bytes > 0) {
    LOG(WARNING) << "spool file " << name << ": the last " << contents.torn_bytes
                 << " bytes are of no whole batch and left out";
  }
  bytes_ += size;
  segments_[number] = {size, contents.records.size()};
  for (const SpoolRecord& record : contents.records) found_.push_back({number, record});
  if (contents.records.empty()) RemoveSegment(number);
  return absl::OkStatus();
}

// A process that was killed may have written what no disk has yet.
absl::Status Spool::SyncFound() {
  for (const auto& [number, segment] : segments_) RETURN_IF_ERROR(files_->Sync(NameOf(number)));
  return absl::OkStatus();
}

absl::Status Spool::StartSegment() {
  open_segment_ = next_segment_++;
  segments_[open_segment_] = {};
  const std::string header = EncodeSegmentHeader(options_.owner);
  const absl::Status written = files_->Append(NameOf(open_segment_), header);
  if (!written.ok()) {
    RemoveSegment(std::exchange(open_segment_, 0));
    return written;
  }
  segments_[open_segment_].bytes = header.size();
  bytes_ += header.size();
  return absl::OkStatus();
}

absl::StatusOr<SpooledBatch> Spool::Append(const MapUpdateBatch& batch, SpoolRecord::Kind kind) {
  ReleasePutOff();
  SpooledBatch spooled;
  spooled.record.kind = kind;
  spooled.record.local_map = batch.local_map;
  spooled.record.number = batch.number;
  spooled.record.closes_local_map = batch.closes_local_map;
  const std::string bytes = EncodeSpoolRecord(spooled.record, codec_.encode(batch));
  if (bytes_ + bytes.size() > options_.max_bytes || bytes.size() > kMaxSpoolPayloadBytes) {
    return absl::ResourceExhaustedError(
        absl::StrCat("the spool has ", bytes_, " bytes; batch ", batch.number, " of local map ",
                     ToString(batch.local_map), " has ", bytes.size(), " more; the limit is ",
                     options_.max_bytes));
  }
  if (open_segment_ != 0 && segments_[open_segment_].bytes >= options_.segment_bytes) {
    if (syncer_ == nullptr) RETURN_IF_ERROR(Sync());
    open_segment_ = 0;
  }
  if (open_segment_ == 0) RETURN_IF_ERROR(StartSegment());
  Segment& segment = segments_[open_segment_];
  if (absl::Status written = files_->Append(NameOf(open_segment_), bytes); !written.ok()) {
    CutOpenSegment();
    return written;
  }
  spooled.order = ++appended_;
  appended_bytes_ += bytes.size();
  if (syncer_ != nullptr) syncer_->NoteWrite(NameOf(open_segment_), appended_, bytes.size());
  spooled.segment = open_segment_;
  spooled.record.offset = segment.bytes;
  spooled.record.bytes = static_cast<uint32_t>(bytes.size());
  segment.bytes += bytes.size();
  bytes_ += bytes.size();
  ++segment.live;
  return spooled;
}

void Spool::CutOpenSegment() {
  const uint64_t number = open_segment_;
  const Segment& segment = segments_[number];
  if (segment.live == 0) {
    open_segment_ = 0;
    RemoveSegment(number);
  } else if (!files_->Truncate(NameOf(number), segment.bytes).ok()) {
    // The segment's tail is torn: nothing may follow it.
    open_segment_ = 0;
  }
}

absl::Status Spool::Sync() {
  if (syncer_ != nullptr) {
    const absl::Status synced = syncer_->SyncNow();
    if (!synced.ok()) NoteSyncError();
    ReleasePutOff();
    return synced;
  }
  if (synced_ == appended_ || open_segment_ == 0) return absl::OkStatus();
  ++syncs_;
  if (absl::Status synced = files_->Sync(NameOf(open_segment_)); !synced.ok()) {
    NoteSyncError();
    return synced;
  }
  synced_ = appended_;
  return absl::OkStatus();
}

void Spool::HurrySync() {
  if (syncer_ != nullptr) {
    syncer_->Hurry();
    return;
  }
  // What could not be synced is above synced().
  error_ = Sync();
}

absl::Status Spool::TakeSyncError() {
  const absl::Status error =
      syncer_ == nullptr ? std::exchange(error_, absl::OkStatus()) : syncer_->TakeError();
  if (!error.ok()) NoteSyncError();
  ReleasePutOff();
  return error;
}

uint64_t Spool::synced() const { return syncer_ == nullptr ? synced_ : syncer_->synced(); }

uint64_t Spool::syncs() const { return syncer_ == nullptr ? syncs_ : syncer_->syncs(); }

absl::StatusOr<MapUpdateBatch> Spool::Read(const SpooledBatch& batch) {
  const std::string name = NameOf(batch.segment);
  ASSIGN_OR_RETURN(const std::string payload, ReadSpoolPayload(*files_, name, batch.record));
  absl::StatusOr<MapUpdateBatch> read = codec_.decode(payload);
  const bool same =
      read.ok() && read->local_map == batch.record.local_map && read->number == batch.record.number;
  if (same) return read;
  return absl::DataLossError(
      absl::StrCat("spool file ", name, ": batch ", batch.record.number, " of local map ",
                   ToString(batch.record.local_map),
                   " can't be read: ", read.ok() ? "it is another one" : read.status().message()));
}

void Spool::Release(const SpooledBatch& batch) {
  const auto it = segments_.find(batch.segment);
  if (it == segments_.end() || it->second.live == 0 || --it->second.live > 0) return;
  if (batch.segment == open_segment_) open_segment_ = 0;
  RemoveSegment(batch.segment);
}

void Spool::ReleaseOnceSynced(const SpooledBatch& batch) {
  if (syncer_ == nullptr) {
    Release(batch);
  } else {
    put_off_.emplace_back(appended_, batch);
  }
}

void Spool::ReleasePutOff() {
  if (put_off_.empty()) return;
  const uint64_t kept = synced();
  while (!put_off_.empty() && put_off_.front().first <= kept) {
    Release(put_off_.front().second);
    put_off_.pop_front();
  }
}

void Spool::NoteSyncError() {
  open_segment_ = 0;
  const uint64_t kept = synced();
  // As many records as were lost are appended first.
  const uint64_t appended_again = appended_ + (appended_ - kept);
  for (auto& [order, batch] : put_off_) {
    if (order > kept) order = appended_again;
  }
}

void Spool::RemoveSegment(uint64_t number) {
  if (syncer_ != nullptr) syncer_->Forget(NameOf(number));
  const absl::Status removed = files_->Remove(NameOf(number));
  if (!removed.ok()) LOG(WARNING) << removed;
  bytes_ -= segments_[number].bytes;
  segments_.erase(number);
}

}  // namespace corbslam::client_agent
