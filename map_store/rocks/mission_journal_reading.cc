// Implements the part of MissionJournal that lends its files to backups, and looks at them now and
// then for damage.
#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "map_store/rocks/files_check.h"
#include "map_store/rocks/mission_journal.h"
#include "map_store/rocks/rocks_database.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Tables and files of features that the database needs must be there, as long as they were.
rocksdb::Status CheckLengths(rocksdb::DB& db) {
  std::vector<rocksdb::LiveFileStorageInfo> files;
  rocksdb::LiveFilesStorageInfoOptions options;
  options.wal_size_for_flush = ~uint64_t{0};  // Flush nothing for this.
  const rocksdb::Status listed = db.GetLiveFilesStorageInfo(options, &files);
  if (!listed.ok()) return listed;
  for (const rocksdb::LiveFileStorageInfo& file : files) {
    if (file.file_type != rocksdb::kTableFile && file.file_type != rocksdb::kBlobFile) continue;
    const std::string path = absl::StrCat(file.directory, "/", file.relative_filename);
    std::error_code error;
    const uint64_t size = std::filesystem::file_size(path, error);
    if (!error && size == file.size) continue;
    // A compaction may have removed it since.
    std::vector<std::string> live;
    uint64_t manifest = 0;
    const rocksdb::Status again = db.GetLiveFiles(live, &manifest, false);
    if (!again.ok()) return again;
    if (std::find(live.begin(), live.end(), "/" + file.relative_filename) == live.end()) continue;
    return rocksdb::Status::Corruption(
        path,
        error ? error.message() : absl::StrCat("has ", size, " bytes and should have ", file.size));
  }
  return rocksdb::Status::OK();
}

// Reads key after key, which compares blocks and features with their checksums.
rocksdb::Status ReadSome(rocksdb::DB& db, uint64_t max_bytes, std::string& from, uint64_t& bytes) {
  rocksdb::ReadOptions options;
  options.verify_checksums = true;
  options.fill_cache = false;
  const std::unique_ptr<rocksdb::Iterator> it(db.NewIterator(options));
  for (it->Seek(from); it->Valid(); it->Next()) {
    if (bytes >= max_bytes) {
      from = it->key().ToString();
      return it->status();
    }
    bytes += it->key().size() + it->value().size();
  }
  from.clear();
  return it->status();
}

}  // namespace

absl::Status MissionJournal::Lend(
    const std::function<rocksdb::Status(rocksdb::DB& db, const std::function<bool()>& goes_on)>&
        use) const {
  RETURN_IF_ERROR(Damage());
  if (database_->failed()) {
    return absl::UnavailableError(absl::StrCat("journal ", database_->directory(),
                                               ": the last write failed, and it is not open"));
  }
  return ToStatus(database_->Lend(use));
}

absl::StatusOr<DatabaseMark> MissionJournal::Mark() const {
  DatabaseMark mark;
  RETURN_IF_ERROR(Lend([&mark](rocksdb::DB& db, const std::function<bool()>&) {
    mark.sequence = db.GetLatestSequenceNumber();
    return db.GetDbIdentity(mark.identity);
  }));
  return mark;
}

absl::Status MissionJournal::ScrubLogs(const ReadPace& pace) const {
  RETURN_IF_ERROR(Damage());
  // The database has read them only just, else.
  if (database_->failed() || options_.only_read) return absl::OkStatus();
  absl::Status checked;
  const rocksdb::Status lent =
      database_->Lend([&](rocksdb::DB& db, const std::function<bool()>& goes_on) {
        checked = CheckLiveFiles(db, [&](uint64_t bytes) { return pace(bytes) && goes_on(); });
        return rocksdb::Status::OK();
      });
  RETURN_IF_ERROR(ToStatus(lent));
  return Note(checked);
}

absl::StatusOr<uint64_t> MissionJournal::Scrub(uint64_t max_bytes, std::string& from) const {
  RETURN_IF_ERROR(Damage());
  if (database_->failed()) return 0;
  uint64_t bytes = 0;
  const bool begins = from.empty();
  const rocksdb::Status read =
      database_->Lend([&](rocksdb::DB& db, const std::function<bool()>& goes_on) {
        const rocksdb::Status lengths =
            begins && !options_.only_read ? CheckLengths(db) : rocksdb::Status::OK();
        if (!lengths.ok() || !goes_on()) return lengths;
        return ReadSome(db, max_bytes, from, bytes);
      });
  // What the process lacks says nothing of the file.
  if (absl::StrContains(read.ToString(), "Too many open files")) {
    return absl::UnavailableError(
        absl::StrCat("journal ", database_->directory(), ": ", read.ToString()));
  }
  RETURN_IF_ERROR(ToReadStatus(read));
  return bytes;
}

}  // namespace corbslam::map_store
