#include "client_agent/source/lists/timed_files.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

// Recognises "timestamp filename" without its #.
bool IsHeading(int line, absl::string_view field) {
  return line == 1 && absl::ascii_isalpha(static_cast<unsigned char>(field.front()));
}

absl::StatusOr<std::vector<TimedFile>> ParseFields(const std::string& directory,
                                                   const std::string& path, int line,
                                                   const std::vector<absl::string_view>& fields,
                                                   size_t per_line) {
  if (fields.size() != 2 * per_line) {
    return LineError(path, line,
                     absl::StrCat(fields.size(), " fields instead of ", 2 * per_line,
                                  per_line == 1 && fields.size() == 4
                                      ? ": a list of pairs is called associated.txt"
                                      : ""));
  }
  std::vector<TimedFile> files;
  for (size_t i = 0; i < fields.size(); i += 2) {
    const absl::StatusOr<int64_t> timestamp_ns = ParseSeconds(fields[i]);
    if (!timestamp_ns.ok()) {
      return LineError(path, line,
                       absl::StrCat("field ", i + 1, ": ", timestamp_ns.status().message()));
    }
    if (*timestamp_ns < 0) {
      return LineError(path, line,
                       absl::StrCat("field ", i + 1, ": the time ", fields[i], " is negative"));
    }
    files.push_back({*timestamp_ns, line, absl::StrCat(directory, "/", fields[i + 1])});
  }
  return files;
}

}  // namespace

absl::StatusOr<std::vector<std::vector<TimedFile>>> ReadTimedFileLines(const std::string& directory,
                                                                       const std::string& path,
                                                                       size_t per_line) {
  std::vector<std::vector<TimedFile>> lines;
  RETURN_IF_ERROR(ForEachLine(path, [&](int line, absl::string_view text) -> absl::Status {
    const std::vector<absl::string_view> fields =
        absl::StrSplit(text, absl::ByAnyChar(" \t,"), absl::SkipEmpty());
    if (fields.empty() || IsHeading(line, fields.front())) return absl::OkStatus();
    ASSIGN_OR_RETURN(lines.emplace_back(), ParseFields(directory, path, line, fields, per_line));
    return absl::OkStatus();
  }));
  return lines;
}

absl::StatusOr<std::vector<TimedFile>> ReadTimedFiles(const std::string& directory,
                                                      const std::string& path,
                                                      SourceRemarks& remarks) {
  ASSIGN_OR_RETURN(const auto lines, ReadTimedFileLines(directory, path, 1));
  std::vector<TimedFile> files;
  for (const std::vector<TimedFile>& line : lines) files.push_back(line.front());
  const auto is_before = [](const TimedFile& a, const TimedFile& b) {
    return a.timestamp_ns < b.timestamp_ns;
  };
  if (!std::is_sorted(files.begin(), files.end(), is_before)) {
    remarks.findings.push_back(
        {FindingLevel::kWarning, "times-out-of-order",
         absl::StrCat(path, ": its times do not grow; it is played in the order of time")});
    std::stable_sort(files.begin(), files.end(), is_before);
  }
  const auto is_same = [](const TimedFile& a, const TimedFile& b) {
    return a.timestamp_ns == b.timestamp_ns && a.path == b.path;
  };
  files.erase(std::unique(files.begin(), files.end(), is_same), files.end());
  if (files.size() < lines.size()) {
    remarks.left_out.push_back(
        absl::StrCat(lines.size() - files.size(), " lines of ", path, " that are there twice"));
  }
  for (size_t i = 1; i < files.size(); ++i) {
    if (files[i].timestamp_ns != files[i - 1].timestamp_ns) continue;
    const auto [first, second] = std::minmax(files[i - 1].line, files[i].line);
    return LineError(
        path, second,
        absl::StrCat("the time ", FormatSeconds(files[i].timestamp_ns), " s stands in line ", first,
                     " too: each picture needs a time of its own"));
  }
  return files;
}

}  // namespace corbslam::client_agent
