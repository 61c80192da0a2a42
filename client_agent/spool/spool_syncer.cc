#include "client_agent/spool/spool_syncer.h"

#include <algorithm>
#include <utility>

#include "absl/time/clock.h"
#include "slam/util/named_thread.h"

namespace corbslam::client_agent {

SpoolSyncer::SpoolSyncer(SpoolFiles* files, const SyncPolicy& policy)
    : files_(files), policy_(policy), thread_(StartThread("spool syncer", [this] { Run(); })) {}

SpoolSyncer::~SpoolSyncer() {
  {
    absl::MutexLock lock(&mutex_);
    stop_ = true;
  }
  thread_.join();
}

void SpoolSyncer::NoteWrite(const std::string& file, uint64_t number, uint64_t bytes) {
  absl::MutexLock lock(&mutex_);
  if (unsynced_.empty()) oldest_ = absl::Now();
  unsynced_[file] = number;
  unsynced_bytes_ += bytes;
  written_ = number;
}

void SpoolSyncer::Forget(const std::string& file) {
  absl::MutexLock lock(&mutex_);
  unsynced_.erase(file);
  syncing_.erase(file);
}

void SpoolSyncer::Hurry() {
  absl::MutexLock lock(&mutex_);
  hurried_ = !unsynced_.empty();
}

bool SpoolSyncer::IsSettled() const { return !error_.ok() || (unsynced_.empty() && !is_syncing_); }

absl::Status SpoolSyncer::SyncNow() {
  absl::MutexLock lock(&mutex_);
  hurried_ = !unsynced_.empty();
  mutex_.Await(absl::Condition(this, &SpoolSyncer::IsSettled));
  return std::exchange(error_, absl::OkStatus());
}

uint64_t SpoolSyncer::synced() const {
  absl::MutexLock lock(&mutex_);
  return synced_;
}

uint64_t SpoolSyncer::syncs() const {
  absl::MutexLock lock(&mutex_);
  return syncs_;
}

absl::Status SpoolSyncer::TakeError() {
  absl::MutexLock lock(&mutex_);
  return std::exchange(error_, absl::OkStatus());
}

bool SpoolSyncer::IsUrgent() const {
  return stop_ || (HasWork() && (hurried_ || unsynced_bytes_ >= policy_.bytes));
}

SpoolSyncer::Files SpoolSyncer::WaitForWork() {
  absl::MutexLock lock(&mutex_);
  const auto comes = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return stop_ || HasWork(); };
  mutex_.Await(absl::Condition(&comes));
  const absl::Duration wait = oldest_ + policy_.after - absl::Now();
  mutex_.AwaitWithTimeout(absl::Condition(this, &SpoolSyncer::IsUrgent), wait);
  if (stop_) return {};
  for (const auto& [file, number] : unsynced_) syncing_.insert(file);
  is_syncing_ = true;
  hurried_ = false;
  unsynced_bytes_ = 0;
  return std::exchange(unsynced_, {});
}

absl::Status SpoolSyncer::SyncFiles(const Files& files) {
  absl::Status first_error;
  for (const auto& [file, number] : files) {
    const absl::Status synced = files_->Sync(file);
    absl::MutexLock lock(&mutex_);
    if (syncing_.contains(file)) first_error.Update(synced);
  }
  return first_error;
}

void SpoolSyncer::NoteSynced(const Files& files, absl::Status synced) {
  absl::MutexLock lock(&mutex_);
  is_syncing_ = false;
  syncing_.clear();
  ++syncs_;
  if (synced.ok()) {
    for (const auto& [file, number] : files) synced_ = std::max(synced_, number);
    return;
  }
  // What came meanwhile is to be written again, too.
  unsynced_.clear();
  error_ = std::move(synced);
}

void SpoolSyncer::Run() {
  while (true) {
    const Files files = WaitForWork();
    bool stop = false;
    {
      absl::MutexLock lock(&mutex_);
      stop = stop_;
    }
    if (stop) return;
    if (!files.empty()) NoteSynced(files, SyncFiles(files));
  }
}

}  // namespace corbslam::client_agent
