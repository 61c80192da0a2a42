#include "map_store/rocks/rocks_database.h"

#include <glog/logging.h>
#include <rocksdb/env.h>
#include <rocksdb/options.h>
#include <rocksdb/table.h>

#include <array>
#include <cstdarg>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>

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

constexpr size_t kBlockCacheBytes = 32 << 20;

// Keeps what each database takes for itself small: there is one for each mission.
void ShareResources(const std::shared_ptr<rocksdb::Cache>& cache, rocksdb::Options& made) {
  rocksdb::BlockBasedTableOptions table;
  table.block_cache = cache;
  made.table_factory.reset(rocksdb::NewBlockBasedTableFactory(table));
  // These would be threads and timers for each database.
  made.stats_dump_period_sec = 0;
  made.stats_persist_period_sec = 0;
}

rocksdb::Options MakeOptions(rocksdb::Env* env, const std::shared_ptr<rocksdb::Cache>& cache) {
  rocksdb::Options made;
  // An end of the log that a crash tore is dropped; damage anywhere else is refused.
  made.wal_recovery_mode = rocksdb::WALRecoveryMode::kTolerateCorruptedTailRecords;
  // A log would otherwise reserve more than a small mission ever takes, for each mission.
  made.allow_fallocate = false;
  // Tables of tens of megabytes that are flushed go to the disk as they are written: synced at the
  // end, they would hold up the log, and with it every acknowledgement. The limit is strict,
  // because a file system that orders data before its own journal waits for whatever is under way.
  made.bytes_per_sync = 1 << 20;
  made.strict_bytes_per_sync = true;
  // A burst of uploads fills one buffer while another is flushed; with two, which is the default,
  // all writers then wait for the disk. All eight together are as large as those two; a mission
  // with little to do has one.
  made.max_write_buffer_number = 8;
  made.write_buffer_size = 16 << 20;
  // Features are large and never change: compaction leaves them where they are.
  made.enable_blob_files = true;
  made.min_blob_size = 16 << 10;
  made.enable_blob_garbage_collection = true;
  made.blob_file_size = 16 << 20;
  made.info_log = std::make_shared<ProgramLog>();
  // RocksDB would try behind our back what Reopen does.
  made.max_bgerror_resume_count = 0;
  if (env != nullptr) made.env = env;
  ShareResources(cache, made);
  return made;
}

}  // namespace

std::shared_ptr<rocksdb::Cache> MakeBlockCache() { return rocksdb::NewLRUCache(kBlockCacheBytes); }

rocksdb::Status RocksDatabase::Open(Mode mode) {
  absl::MutexLock lock(&mutex_);
  return OpenLocked(mode);
}

rocksdb::Status RocksDatabase::OpenLocked(Mode mode) {
  rocksdb::DB* opened = nullptr;
  rocksdb::Options options = MakeOptions(env_, cache_);
  options.create_if_missing = mode == Mode::kMake;
  if (options.create_if_missing) {
    // RocksDB says an error in the log where there is no folder, and then makes it. What keeps it
    // from being made keeps RocksDB, too, which says so.
    std::error_code error;
    std::filesystem::create_directories(directory_, error);
  }
  if (mode == Mode::kSalvage) {
    options.wal_recovery_mode = rocksdb::WALRecoveryMode::kPointInTimeRecovery;
    options.paranoid_checks = false;
  }
  options.best_efforts_recovery = mode == Mode::kBestEfforts;
  const bool only_reads = mode == Mode::kOnlyRead || mode == Mode::kSalvage;
  const rocksdb::Status status = only_reads
                                     ? rocksdb::DB::OpenForReadOnly(options, directory_, &opened)
                                     : rocksdb::DB::Open(options, directory_, &opened);
  if (!status.ok()) return status;
  db_.reset(opened);
  only_reads_ = only_reads;
  return status;
}

void RocksDatabase::Destroy(const std::string& directory) {
  const rocksdb::Status destroyed = rocksdb::DestroyDB(directory, MakeOptions(nullptr, nullptr));
  LOG_IF(WARNING, !destroyed.ok()) << directory << ": " << destroyed.ToString();
}

void RocksDatabase::Close() {
  closing_.store(true);
  absl::MutexLock tidied(&tidying_);
  std::unique_ptr<rocksdb::DB> closed;
  absl::MutexLock lock(&mutex_);
  closed.swap(db_);
  // Whoever reads at this moment ends soon, and nobody can begin any more.
  const auto is_free = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return users_ == 0; };
  mutex_.Await(absl::Condition(&is_free));
}

std::shared_ptr<rocksdb::DB> RocksDatabase::Use() const {
  absl::MutexLock lock(&mutex_);
  if (db_ == nullptr) return nullptr;
  ++users_;
  return {db_.get(), [this](rocksdb::DB*) {
            absl::MutexLock done(&mutex_);
            --users_;
          }};
}

rocksdb::Status RocksDatabase::Tidy() {
  // RocksDB's own threads do it, one for all databases. They are not of a lower priority: starved,
  // they would let tables pile up until writes have to wait for them.
  absl::MutexLock tidying(&tidying_);
  const std::shared_ptr<rocksdb::DB> db = Use();
  if (db == nullptr || closing_.load()) return rocksdb::Status::Incomplete("closed");
  rocksdb::CompactRangeOptions options;
  options.canceled = &closing_;
  // Else the lowest tables would stay as they are, and with them the files of features.
  options.bottommost_level_compaction = rocksdb::BottommostLevelCompaction::kForceOptimized;
  options.blob_garbage_collection_policy = rocksdb::BlobGarbageCollectionPolicy::kForce;
  options.blob_garbage_collection_age_cutoff = 1;
  return db->CompactRange(options, nullptr, nullptr);
}

rocksdb::Status RocksDatabase::Flush() {
  const std::shared_ptr<rocksdb::DB> db = Use();
  if (db == nullptr) return rocksdb::Status::Aborted("the journal is closed");
  return db->Flush(rocksdb::FlushOptions());
}

uint64_t RocksDatabase::BytesInMemory() const {
  const std::shared_ptr<rocksdb::DB> db = Use();
  uint64_t bytes = 0;
  if (db != nullptr) db->GetIntProperty(rocksdb::DB::Properties::kSizeAllMemTables, &bytes);
  return bytes;
}

rocksdb::Status RocksDatabase::VerifyChecksums() const {
  const std::shared_ptr<rocksdb::DB> db = Use();
  if (db == nullptr) return rocksdb::Status::Aborted("the journal is closed");
  return db->VerifyChecksum();
}

rocksdb::Status RocksDatabase::Lend(
    const std::function<rocksdb::Status(rocksdb::DB& db, const GoesOn& goes_on)>& use) const {
  const std::shared_ptr<rocksdb::DB> db = Use();
  if (db == nullptr) return rocksdb::Status::Aborted("the journal is closed");
  return use(*db, [this] { return !closing_.load() && !failed_.load(); });
}

rocksdb::Status RocksDatabase::Reopen() {
  absl::MutexLock lock(&mutex_);
  if (!failed_.load()) return rocksdb::Status::OK();
  if (closing_.load()) return rocksdb::Status::Aborted("the journal is closed");
  const absl::Time now = absl::Now();
  // After corruption (see below) only a new process may open it. Two databases in one folder can't
  // be.
  if (last_failure_.IsCorruption() || now < last_try_ + kBetweenTries || users_ > 0) {
    return last_failure_;
  }
  last_try_ = now;
  db_.reset();
  last_failure_ = OpenLocked(Mode::kOpen);
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
  bool only_reads = false;
  {
    absl::MutexLock lock(&mutex_);
    only_reads = only_reads_;
  }
  if (only_reads) return Seek(*db, key, value);
  return db->Get(rocksdb::ReadOptions(), key, value);
}

// A database that is only read finds no value by Get that lies in a file of its own (blob), up to
// RocksDB 7.8 at least, and says NotFound; an iterator finds it.
rocksdb::Status RocksDatabase::Seek(rocksdb::DB& db, const std::string& key, std::string* value) {
  rocksdb::ReadOptions options;
  const std::string end = key + '\0';
  const rocksdb::Slice bound(end);
  options.iterate_upper_bound = &bound;
  const std::unique_ptr<rocksdb::Iterator> it(db.NewIterator(options));
  it->Seek(key);
  if (!it->status().ok()) return it->status();
  if (!it->Valid()) return rocksdb::Status::NotFound();
  *value = it->value().ToString();
  return rocksdb::Status::OK();
}

}  // namespace corbslam::map_store
