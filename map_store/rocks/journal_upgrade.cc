#include "map_store/rocks/journal_upgrade.h"

#include <glog/logging.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/journal_keys.h"
#include "map_store/rocks/mission_header.h"
#include "slam/util/status_macros.h"
#include "slam/util/whole_file.h"

namespace corbslam::map_store {
namespace {

constexpr size_t kBytesOfABatch = 4 << 20;
constexpr char kUpgrading[] = "missions.upgrading";
// Says in that folder of what the copies in it are.
constexpr char kSourceFile[] = "SOURCE";

absl::Status ToStatus(const std::string& path, const rocksdb::Status& status) {
  if (status.ok()) return absl::OkStatus();
  const std::string message = absl::StrCat("journal ", path, ": ", status.ToString());
  return status.IsNoSpace() ? absl::ResourceExhaustedError(message)
                            : absl::UnavailableError(message);
}

// Copies all keys of one part.
absl::Status CopyPart(const RocksDatabase& shared, const std::string& prefix, RocksDatabase& own) {
  rocksdb::WriteBatch batch;
  RETURN_IF_ERROR(
      shared.Scan(prefix, EndOfPrefix(prefix), [&](std::string_view key, std::string_view value) {
        batch.Put(rocksdb::Slice(key.data(), key.size()),
                  rocksdb::Slice(value.data(), value.size()));
        if (batch.GetDataSize() < kBytesOfABatch) return absl::OkStatus();
        const absl::Status written = ToStatus(own.directory(), own.Write(batch, false));
        batch.Clear();
        return written;
      }));
  return ToStatus(own.directory(), own.Write(batch, false));
}

absl::Status CopyMission(const std::string& name, const RocksDatabase& shared, RocksDatabase& own) {
  for (const JournalPart part : {JournalPart::kMission, JournalPart::kRecord,
                                 JournalPart::kSnapshot, JournalPart::kFeatures}) {
    RETURN_IF_ERROR(CopyPart(shared, MissionPrefix(part, name), own));
  }
  rocksdb::WriteBatch format;
  format.Put(map_store::FormatKey(), EncodeFormat());
  return ToStatus(own.directory(), own.Write(format, true));
}

// What is copied already takes no more.
absl::Status CheckDisk(const RocksJournalOptions& options, uint64_t copied) {
  const uint64_t all = BytesIn(options.directory) - copied;
  const uint64_t bytes = all - std::min(all, copied);
  std::error_code error;
  const auto space = std::filesystem::space(options.directory, error);
  if (error || space.available > bytes) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("journal ", options.directory,
                   " is of an older format; becoming the new one "
                   "takes as much room as it has now, ",
                   bytes, " bytes, and the disk has ", space.available,
                   " free: make room, or move the folder to a larger disk"));
}

// Returns what is different once anything was written to the database.
absl::StatusOr<std::string> DescribeSource(const RocksDatabase& shared) {
  std::string identity;
  uint64_t sequence = 0;
  RETURN_IF_ERROR(
      ToStatus(shared.directory(), shared.Lend([&](rocksdb::DB& db, const std::function<bool()>&) {
        sequence = db.GetLatestSequenceNumber();
        return db.GetDbIdentity(identity);
      })));
  return absl::StrCat(identity, " ", sequence, "\n");
}

std::string ReadSource(const JournalFolder& folder) {
  std::ifstream file(absl::StrCat(folder.path(), "/", kSourceFile));
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// Has the folder hold copies of this source only: what an upgrade that was cut short has copied
// stays, unless an older program has written since.
absl::Status PrepareFolder(const JournalFolder& folder, const std::string& source) {
  if (ReadSource(folder) == source) return absl::OkStatus();
  std::error_code error;
  std::filesystem::remove_all(folder.path(), error);
  RETURN_IF_ERROR(folder.Make());
  ASSIGN_OR_RETURN(WholeFile file,
                   WholeFile::Create(absl::StrCat(folder.path(), "/", kSourceFile)));
  RETURN_IF_ERROR(file.Append(source));
  return file.Finish();
}

// The format is what is written last.
bool IsCopied(const std::string& path, const RocksJournalOptions& options,
              const std::shared_ptr<rocksdb::Cache>& cache) {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) return false;
  RocksDatabase own(path, options.env, cache);
  std::string bytes;
  return own.Open(RocksDatabase::Mode::kOpen).ok() &&
         own.Get(map_store::FormatKey(), &bytes).ok() && bytes == EncodeFormat();
}

}  // namespace

absl::StatusOr<std::vector<std::string>> ListSharedMissions(const RocksDatabase& shared) {
  std::vector<std::string> names;
  const std::string first(1, static_cast<char>(JournalPart::kMission));
  RETURN_IF_ERROR(shared.Scan(first, EndOfPrefix(first),
                              [&](std::string_view key, std::string_view value) -> absl::Status {
                                ASSIGN_OR_RETURN(const MissionHeader header, DecodeHeader(value));
                                if (header.snapshot_position != kNotWhole)
                                  names.emplace_back(key.substr(1, key.size() - 2));
                                return absl::OkStatus();
                              }));
  return names;
}

absl::Status UpgradeJournal(const RocksJournalOptions& options, const RocksDatabase& shared,
                            const std::shared_ptr<rocksdb::Cache>& cache) {
  const JournalFolder folder(options.directory, kUpgrading);
  ASSIGN_OR_RETURN(const std::string source, DescribeSource(shared));
  RETURN_IF_ERROR(PrepareFolder(folder, source));
  RETURN_IF_ERROR(CheckDisk(options, BytesIn(folder.path())));
  ASSIGN_OR_RETURN(const std::vector<std::string> names, ListSharedMissions(shared));
  std::error_code error;
  for (const std::string& name : names) {
    if (IsCopied(folder.PathOf(name), options, cache)) {
      LOG(INFO) << "mission " << name << " has moved into a folder of its own before";
      continue;
    }
    LOG(INFO) << "mission " << name << " moves into a folder of its own";
    RETURN_IF_ERROR(folder.Remove(name, kKept));
    RocksDatabase own(folder.PathOf(name), options.env, cache);
    RETURN_IF_ERROR(ToStatus(own.directory(), own.Open(RocksDatabase::Mode::kMake)));
    RETURN_IF_ERROR(CopyMission(name, shared, own));
  }
  std::filesystem::remove(absl::StrCat(folder.path(), "/", kSourceFile), error);
  RETURN_IF_ERROR(SyncFolder(folder.path()));
  std::filesystem::rename(folder.path(), JournalFolder(options.directory).path(), error);
  if (error) {
    return absl::UnavailableError(
        absl::StrCat(folder.path(), ": can't be renamed: ", error.message()));
  }
  return SyncFolder(options.directory);
}

}  // namespace corbslam::map_store
