#include "map_store/rocks/files_check.h"

#include <rocksdb/db.h>
#include <rocksdb/transaction_log.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

#include "absl/status/statusor.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/strip.h"
#include "map_store/rocks/durable_mark.h"
#include "map_store/rocks/summary_file.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;

std::string PathIn(const std::string& folder, absl::string_view name) {
  return absl::StrCat(folder, "/", name);
}

// Returns the names of the folder's files with that beginning and end, in their order.
std::vector<std::string> ListFiles(const std::string& folder, absl::string_view begin,
                                   absl::string_view end) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), last; !error && it != last; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (absl::StartsWith(name, begin) && absl::EndsWith(name, end)) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

void CheckLog(const std::string& path, const ReadPace& goes_on, FilesCheck& found) {
  const absl::StatusOr<LogFileCheck> log = CheckLogFile(path, ~uint64_t{0}, goes_on);
  if (absl::IsCancelled(log.status())) return;
  if (!log.ok()) {
    found.damaged.emplace_back(log.status().message());
  } else if (!log->problem.empty()) {
    (log->may_be_torn ? found.torn : found.damaged)
        .push_back(absl::StrCat(path, ": ", log->problem));
  }
}

void CheckListOfFiles(const std::string& folder, const ReadPace& goes_on, FilesCheck& found) {
  const std::string current = ReadCurrentFile(folder);
  absl::string_view name = current;
  if (!absl::ConsumeSuffix(&name, "\n") || !absl::StartsWith(name, "MANIFEST-")) {
    const bool is_there = fs::exists(PathIn(folder, "CURRENT"));
    found.damaged.push_back(
        absl::StrCat(PathIn(folder, "CURRENT"), is_there ? " names no list of files" : " is lost"));
    // There is one, but for an opening that was cut short.
    for (const std::string& list : ListFiles(folder, "MANIFEST-", "")) {
      CheckLog(PathIn(folder, list), goes_on, found);
    }
    return;
  }
  CheckLog(PathIn(folder, name), goes_on, found);
}

// RocksDB writes what it is opened with; nothing reads it again.
bool IsIntactOptions(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const bool is_text = std::all_of(text.begin(), text.end(),
                                   [](char c) { return c == '\n' || (c >= ' ' && c <= '~'); });
  return is_text && absl::StrContains(text, "[Version]") &&
         absl::StrContains(text, "[DBOptions]") && absl::StrContains(text, "[TableOptions");
}

void NoteWhatLosesNothing(const std::string& folder, FilesCheck& found) {
  const std::vector<std::string> options = ListFiles(folder, "OPTIONS-", "");
  for (const std::string& name : options) {
    if (absl::EndsWith(name, ".dbtmp") || IsIntactOptions(PathIn(folder, name))) continue;
    found.notes.push_back(absl::StrCat(PathIn(folder, name),
                                       " is damaged; nothing needs it, and the next start writes "
                                       "another one"));
  }
  if (options.empty()) {
    found.notes.push_back(absl::StrCat(PathIn(folder, "OPTIONS-*"),
                                       " is lost; nothing needs it, and the next start writes "
                                       "another one"));
  }
  if (const absl::Status summary = ReadSummaryFile(folder).status(); absl::IsDataLoss(summary)) {
    found.notes.push_back(absl::StrCat(summary.message(), "; the mission is read at the start"));
  }
  const std::string mark = PathIn(folder, kDurableMark);
  if (fs::exists(mark) && ReadDurableMark(folder) == 0) {
    found.notes.push_back(absl::StrCat(
        mark, " is damaged; until it is written again nothing shows that a log ends early"));
  }
}

std::vector<std::string> ListLogs(rocksdb::DB& db) {
  rocksdb::VectorLogPtr logs;
  std::vector<std::string> names;
  if (!db.GetSortedWalFiles(logs).ok()) return names;
  for (const auto& log : logs) names.push_back(log->PathName());
  return names;
}

bool IsLive(rocksdb::DB& db, const rocksdb::LiveFileStorageInfo& file) {
  std::vector<std::string> live;
  uint64_t list_bytes = 0;
  const std::string name = "/" + file.relative_filename;
  if (!db.GetLiveFiles(live, &list_bytes, /*flush_memtable=*/false).ok()) return true;
  const std::vector<std::string> logs = ListLogs(db);
  return std::find(live.begin(), live.end(), name) != live.end() ||
         std::find(logs.begin(), logs.end(), name) != logs.end();
}

// Returns the sequence number of the last write in the file, if it is a log.
absl::StatusOr<uint64_t> CheckLiveLog(rocksdb::DB& db, const rocksdb::LiveFileStorageInfo& file,
                                      bool is_written_to, const ReadPace& goes_on) {
  const std::string path = PathIn(file.directory, file.relative_filename);
  const absl::StatusOr<LogFileCheck> log = CheckLogFile(path, file.size, goes_on);
  if (absl::IsCancelled(log.status())) return log.status();
  std::string problem(log.ok() ? log->problem : log.status().message());
  if (log.ok() && log->may_be_torn && is_written_to) problem.clear();
  if (log.ok() && problem.empty() && log->bytes < file.size) {
    problem = absl::StrCat("it has ", log->bytes, " bytes and should have ", file.size);
  }
  if (problem.empty()) return log->last_sequence;
  // It may have been removed, or another one begun, since.
  if (!IsLive(db, file)) return uint64_t{0};
  return absl::DataLossError(log.ok() ? absl::StrCat(path, ": ", problem) : problem);
}

}  // namespace

absl::Status FilesCheck::status() const {
  return damaged.empty() ? absl::OkStatus() : absl::DataLossError(absl::StrJoin(damaged, "; "));
}

std::string ReadCurrentFile(const std::string& folder) {
  std::ifstream file(PathIn(folder, "CURRENT"), std::ios::binary);
  std::string text(64, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  return text;
}

FilesCheck CheckClosedFiles(const std::string& folder, const ReadPace& goes_on) {
  FilesCheck found;
  CheckListOfFiles(folder, goes_on, found);
  const std::vector<std::string> logs = ListFiles(folder, "", ".log");
  for (const std::string& name : logs) {
    CheckLog(PathIn(folder, name), goes_on, found);
  }
  if (logs.empty()) found.damaged.push_back(PathIn(folder, "*.log") + " is lost");
  NoteWhatLosesNothing(folder, found);
  return found;
}

absl::Status NameDamagedFiles(const std::string& folder, const absl::Status& error) {
  if (!absl::IsDataLoss(error)) return error;
  std::string text(error.message());
  const FilesCheck found = CheckClosedFiles(folder);
  for (const std::vector<std::string>* files : {&found.damaged, &found.torn}) {
    for (const std::string& file : *files) {
      if (!absl::StrContains(text, file)) absl::StrAppend(&text, "; ", file);
    }
  }
  return absl::DataLossError(text);
}

absl::Status CheckLiveFiles(rocksdb::DB& db, const ReadPace& goes_on) {
  const std::vector<std::string> logs = ListLogs(db);
  uint64_t in_memory = 0;
  db.GetIntProperty(rocksdb::DB::Properties::kNumEntriesActiveMemTable, &in_memory);
  const uint64_t written = in_memory > 0 ? db.GetLatestSequenceNumber() : 0;
  std::vector<rocksdb::LiveFileStorageInfo> files;
  rocksdb::LiveFilesStorageInfoOptions options;
  options.wal_size_for_flush = ~uint64_t{0};  // Flush nothing for this.
  const std::string folder = db.GetName();
  const rocksdb::Status listed = db.GetLiveFilesStorageInfo(options, &files);
  // It looks at the beginning of each log.
  if (listed.IsCorruption()) return CheckClosedFiles(folder, goes_on).status();
  if (!listed.ok()) return absl::OkStatus();
  uint64_t last = 0;
  for (const rocksdb::LiveFileStorageInfo& file : files) {
    const bool is_log = file.file_type == rocksdb::kWalFile;
    if (!is_log && file.file_type != rocksdb::kDescriptorFile) continue;
    const bool is_written_to =
        is_log && !logs.empty() && logs.back() == "/" + file.relative_filename;
    ASSIGN_OR_RETURN(const uint64_t sequence, CheckLiveLog(db, file, is_written_to, goes_on));
    if (is_log) last = std::max(last, sequence);
  }
  for (const rocksdb::LiveFileStorageInfo& file : files) {
    if (file.file_type != rocksdb::kCurrentFile ||
        ReadCurrentFile(folder) == file.replacement_contents)
      continue;
    return absl::DataLossError(PathIn(folder, "CURRENT") + " is lost, or names no list of files");
  }
  // Nothing was flushed meanwhile: the logs hold what memory holds.
  if (last >= written || ListLogs(db) != logs) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat(PathIn(folder, "*.log"), ": ", written,
                                          " writes were made, and only those up to ", last,
                                          " are there: a log ends early"));
}

}  // namespace corbslam::map_store
