#include "map_store/rocks/rocks_database.h"

#include <glog/logging.h>
#include <rocksdb/env.h>
#include <rocksdb/options.h>

#include <array>
#include <cstdarg>
#include <cstdio>
#include <memory>

#include "absl/time/clock.h"

namespace corbslam::map_store {
namespace {

constexpr absl::Duration kBetweenTries = absl::Seconds(1);

// Writes RocksDB's messages into this program's log. A log file beside the database, which is the
// default, fails with the disk, and the library's assertions don't let it be written to after that.
class ProgramLog : public rocksdb::Logger {
 public:
  ProgramLog() : Logger(rocksdb::InfoLogLevel::WARN_LEVEL) {}

  using Logger::Logv;
  void Logv(const char* format, va_list arguments) override {
    std::array<char, 512> line;
    std::vsnprintf(line.data(), line.size(), format, arguments);
    LOG(WARNING) << "rocksdb: " << line.data();
  }
};

rocksdb::Options MakeOptions(rocksdb::Env* env) {
  rocksdb::Options made;
  made.create_if_missing = true;
  // An end of the log that a crash tore is dropped; damage anywhere else is refused.
  made.wal_recovery_mode = rocksdb::WALRecoveryMode::kTolerateCorruptedTailRecords;
  made.max_total_wal_size = 256 << 20;
  // Tables of tens of megabytes that are flushed go to the disk as they are written: synced at the
  // end, they would hold up the log, and with it every acknowledgement. The limit is strict,
  // because a file system that orders data before its own journal waits for whatever is under way.
  made.bytes_per_sync = 1 << 20;
  made.strict_bytes_per_sync = true;
  // A burst of uploads fills one buffer while another is flushed; with two, which is the default,
  // all writers then wait for the disk. All four together are as large as those two.
  made.max_write_buffer_number = 4;
  made.write_buffer_size = 32 << 20;
  // Features are large and never change: compaction leaves them where they are.
  made.enable_blob_files = true;
  made.min_blob_size = 16 << 10;
  made.enable_blob_garbage_collection = true;
  made.info_log = std::make_shared<ProgramLog>();
  // RocksDB would try behind our back what Reopen does.
  made.max_bgerror_resume_count = 0;
  if (env != nullptr) made.env = env;
  return made;
}

}  // namespace

rocksdb::Status RocksDatabase::Open() {
  absl::MutexLock lock(&mutex_);
  return OpenLocked();
}

rocksdb::Status RocksDatabase::OpenLocked() {
  rocksdb::DB* opened = nullptr;
  rocksdb::Status status = rocksdb::DB::Open(MakeOptions(env_), directory_, &opened);
  if (status.ok()) db_.reset(opened);
  return status;
}

rocksdb::Status RocksDatabase::Reopen() {
  absl::MutexLock lock(&mutex_);
  if (!failed_.load()) return rocksdb::Status::OK();
  const absl::Time now = absl::Now();
  // After corruption (see below) only a new process may open it. Two databases in one folder can't
  // be.
  if (last_failure_.IsCorruption() || now < last_try_ + kBetweenTries || db_.use_count() > 1) {
    return last_failure_;
  }
  last_try_ = now;
  db_.reset();
  last_failure_ = OpenLocked();
  if (!last_failure_.ok()) return last_failure_;
  // The log gives back writes in their order, but perhaps not the last ones.
  if (db_->GetLatestSequenceNumber() < last_written_.load()) {
    db_.reset();
    last_failure_ = rocksdb::Status::Corruption(
        "writes before a failure are not all there; start this process again");
    return last_failure_;
  }
  failed_.store(false);
  return rocksdb::Status::OK();
}

rocksdb::Status RocksDatabase::Fail(const rocksdb::Status& status) {
  absl::MutexLock lock(&mutex_);
  last_failure_ = status;
  failed_.store(true);
  return status;
}

void RocksDatabase::NoteWritten(uint64_t written) {
  uint64_t known = last_written_.load();
  while (known < written && !last_written_.compare_exchange_weak(known, written)) {
  }
}

rocksdb::Status RocksDatabase::Write(rocksdb::WriteBatch& batch, bool sync) {
  if (failed_.load()) {
    rocksdb::Status reopened = Reopen();
    if (!reopened.ok()) return reopened;
  }
  const std::shared_ptr<rocksdb::DB> db = Use();
  if (db == nullptr) return rocksdb::Status::Aborted("the journal is closed");
  rocksdb::WriteOptions options;
  options.sync = sync;
  const rocksdb::Status status = db->Write(options, &batch);
  if (!status.ok()) return Fail(status);
  NoteWritten(db->GetLatestSequenceNumber());
  return status;
}

rocksdb::Status RocksDatabase::SyncLog() {
  // Opening the database again puts what the log held into tables, and those are synced.
  if (failed_.load()) return Reopen();
  const std::shared_ptr<rocksdb::DB> db = Use();
  if (db == nullptr) return rocksdb::Status::Aborted("the journal is closed");
  const rocksdb::Status status = db->SyncWAL();
  return status.ok() ? status : Fail(status);
}

rocksdb::Status RocksDatabase::Get(const std::string& key, std::string* value) const {
  const std::shared_ptr<rocksdb::DB> db = Use();
  if (db == nullptr) return rocksdb::Status::Aborted("the journal is closed");
  return db->Get(rocksdb::ReadOptions(), key, value);
}

}  // namespace corbslam::map_store
