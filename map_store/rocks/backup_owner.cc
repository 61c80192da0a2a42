#include "map_store/rocks/backup_owner.h"

#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "map_store/state/mission_uid.h"
#include "slam/util/atomic_file.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

using Lines = std::map<std::string, std::string>;

// Reads lines of the form key=value; none where there is no such file.
Lines ReadLines(const std::string& path) {
  Lines lines;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    lines.insert(
        std::pair<std::string, std::string>(absl::StrSplit(line, absl::MaxSplits('=', 1))));
  }
  return lines;
}

absl::Status WriteFile(const std::string& path, const std::string& text, AtomicFile::Old old) {
  ASSIGN_OR_RETURN(AtomicFile file, AtomicFile::Create(path, old));
  RETURN_IF_ERROR(file.Append(text));
  return file.Finish();
}

std::string HostName() {
  std::array<char, 256> name = {};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

absl::Status OthersError(const std::string& backups, Lines owner) {
  return absl::FailedPreconditionError(absl::StrCat(
      "--backup-dir ", backups, " is of another store, whose id is ", owner["store"],
      ", with data in ", owner["data_dir"], " on ", owner["host"], ", since ", owner["since"],
      ": two stores in one folder would remove each other's backups. Give this one a folder of its "
      "own; or, if that store is gone and this one takes its place, start it with "
      "--backup-take-over ",
      owner["store"]));
}

}  // namespace

absl::StatusOr<std::string> EnsureStoreId(const std::string& journal_folder) {
  const std::string path = absl::StrCat(journal_folder, "/", kStoreIdFile);
  std::string id = ReadLines(path)["store"];
  if (IsMissionUid(id)) return id;
  id = DrawMissionUid("");
  // Who starts from an older version has none; a file that can't be read is written anew.
  RETURN_IF_ERROR(WriteFile(path, absl::StrCat("store=", id, "\n"), AtomicFile::Old::kReplaced));
  return id;
}

absl::Status ClaimBackupFolder(const std::string& backups, const std::string& store_id,
                               const std::string& journal_folder,
                               const std::string& take_over_from) {
  const std::string path = absl::StrCat(backups, "/", kOwnerFile);
  std::error_code error;
  const bool is_there = std::filesystem::exists(path, error);
  const std::string before = ReadLines(path)["store"];
  if (before == store_id) return absl::OkStatus();
  if (is_there && (before.empty() || before != take_over_from)) {
    return CheckOwnsBackupFolder(backups, store_id);
  }
  const std::string lines = absl::StrCat(
      "store=", store_id, "\ndata_dir=", std::filesystem::absolute(journal_folder, error).string(),
      "\nhost=", HostName(),
      "\nsince=", absl::FormatTime("%Y-%m-%dT%H:%M:%SZ", absl::Now(), absl::UTCTimeZone()), "\n");
  const absl::Status written =
      WriteFile(path, lines, is_there ? AtomicFile::Old::kReplaced : AtomicFile::Old::kStays);
  // Another store may have been faster.
  if (absl::IsAlreadyExists(written)) return CheckOwnsBackupFolder(backups, store_id);
  return written;
}

absl::Status CheckOwnsBackupFolder(const std::string& backups, const std::string& store_id) {
  const std::string path = absl::StrCat(backups, "/", kOwnerFile);
  Lines owner = ReadLines(path);
  if (owner["store"] == store_id) return absl::OkStatus();
  if (!owner["store"].empty()) return OthersError(backups, std::move(owner));
  std::error_code error;
  return absl::FailedPreconditionError(absl::StrCat(
      path, std::filesystem::exists(path, error) ? " can't be read" : " is gone",
      ", which says whose backups these are: if they are this store's, ",
      std::filesystem::exists(path, error) ? "delete the file and start the store again"
                                           : "start the store again"));
}

}  // namespace corbslam::map_store
