#include "map_store/rocks/journal_upgrade.h"

#include <glog/logging.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/journal_keys.h"
#include "map_store/rocks/mission_header.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

constexpr size_t kBytesOfABatch = 4 << 20;
constexpr char kUpgrading[] = "missions.upgrading";

absl::Status ToStatus(const std::string& path, const rocksdb::Status& status) {
  if (status.ok()) return absl::OkStatus();
  const std::string message = absl::StrCat("journal ", path, ": ", status.ToString());
  return status.IsNoSpace() ? absl::ResourceExhaustedError(message)
                            : absl::UnavailableError(message);
}

// Returns the missions that are whole: of the others nobody was told.
absl::StatusOr<std::vector<std::string>> ListMissions(const RocksDatabase& shared) {
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

absl::Status CheckDisk(const RocksJournalOptions& options) {
  const uint64_t bytes = BytesIn(options.directory);
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

}  // namespace

absl::Status UpgradeJournal(const RocksJournalOptions& options, const RocksDatabase& shared,
                            const std::shared_ptr<rocksdb::Cache>& cache) {
  const JournalFolder folder(options.directory, kUpgrading);
  std::error_code error;
  std::filesystem::remove_all(folder.path(), error);
  RETURN_IF_ERROR(CheckDisk(options));
  RETURN_IF_ERROR(folder.Make());
  ASSIGN_OR_RETURN(const std::vector<std::string> names, ListMissions(shared));
  for (const std::string& name : names) {
    LOG(INFO) << "mission " << name << " moves into a folder of its own";
    RocksDatabase own(folder.PathOf(name), options.env, cache);
    RETURN_IF_ERROR(ToStatus(own.directory(), own.Open(RocksDatabase::Mode::kMake)));
    RETURN_IF_ERROR(CopyMission(name, shared, own));
  }
  RETURN_IF_ERROR(SyncFolder(folder.path()));
  std::filesystem::rename(folder.path(), JournalFolder(options.directory).path(), error);
  if (error) {
    return absl::UnavailableError(
        absl::StrCat(folder.path(), ": can't be renamed: ", error.message()));
  }
  return SyncFolder(options.directory);
}

}  // namespace corbslam::map_store
