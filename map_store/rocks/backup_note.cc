#include "map_store/rocks/backup_note.h"

#include <map>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

using NoteLines = std::map<std::string, std::string, std::less<>>;

template <typename Number>
absl::Status ReadNumber(const NoteLines& lines, const std::string& key, Number* number) {
  const auto it = lines.find(key);
  if (it != lines.end() && absl::SimpleAtoi(it->second, number)) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat(
      "the backup's note has ", it == lines.end() ? "no number" : it->second, " as its ", key));
}

}  // namespace

std::string Encode(const BackupNote& note) {
  return absl::StrCat("created_ns=", absl::ToUnixNanos(note.facts.created),
                      "\nrevision=", note.facts.revision, "\nkeyframes=", note.facts.keyframes,
                      "\narchived=", note.facts.archived ? 1 : 0, "\nuid=", note.facts.mission_uid,
                      "\nidentity=", note.mark.identity, "\nsequence=", note.mark.sequence,
                      "\nformat=", note.format, "\nprogram=", note.program, "\n");
}

absl::StatusOr<BackupNote> DecodeBackupNote(absl::string_view text) {
  NoteLines lines;
  for (const absl::string_view line : absl::StrSplit(text, '\n', absl::SkipEmpty())) {
    const std::pair<std::string, std::string> entry = absl::StrSplit(line, absl::MaxSplits('=', 1));
    lines.insert(entry);
  }
  BackupNote note;
  int64_t created_ns = 0;
  int archived = 0;
  RETURN_IF_ERROR(ReadNumber(lines, "created_ns", &created_ns));
  RETURN_IF_ERROR(ReadNumber(lines, "revision", &note.facts.revision));
  RETURN_IF_ERROR(ReadNumber(lines, "keyframes", &note.facts.keyframes));
  RETURN_IF_ERROR(ReadNumber(lines, "archived", &archived));
  RETURN_IF_ERROR(ReadNumber(lines, "sequence", &note.mark.sequence));
  RETURN_IF_ERROR(ReadNumber(lines, "format", &note.format));
  note.facts.created = absl::FromUnixNanos(created_ns);
  note.facts.archived = archived != 0;
  note.facts.mission_uid = lines["uid"];
  note.mark.identity = lines["identity"];
  note.program = lines["program"];
  return note;
}

}  // namespace corbslam::map_store
