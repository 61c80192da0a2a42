#include "client_agent/source/lists/camera_list.h"

#include <algorithm>
#include <cstdlib>
#include <optional>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

bool IsBefore(const ListedPicture& a, const ListedPicture& b) {
  return a.timestamp_ns < b.timestamp_ns;
}

// Recognises "timestamp [ns],filename" without its #.
bool IsHeading(absl::string_view field) {
  return !field.empty() && absl::ascii_isalpha(static_cast<unsigned char>(field.front()));
}

absl::StatusOr<std::optional<ListedPicture>> ParsePicture(const std::string& path, int line,
                                                          absl::string_view text) {
  const std::pair<absl::string_view, absl::string_view> fields =
      absl::StrSplit(text, absl::MaxSplits(absl::ByAnyChar(",;\t"), 1));
  const absl::string_view time = absl::StripAsciiWhitespace(fields.first);
  ListedPicture picture;
  picture.line = line;
  if (!absl::SimpleAtoi(time, &picture.timestamp_ns)) {
    if (line == 1 && IsHeading(time)) return std::nullopt;
    return LineError(path, line, absl::StrCat("field 1 is no time in whole nanoseconds: ", time));
  }
  if (picture.timestamp_ns < 0) {
    return LineError(path, line, absl::StrCat("the time ", time, " is negative"));
  }
  picture.file = std::string(absl::StripAsciiWhitespace(fields.second));
  if (picture.file.empty()) return LineError(path, line, "field 2 names no file");
  return picture;
}

absl::Status CheckTimesDiffer(const std::string& path, const std::vector<ListedPicture>& sorted) {
  for (size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i].timestamp_ns != sorted[i - 1].timestamp_ns) continue;
    const auto [first, second] = std::minmax(sorted[i - 1].line, sorted[i].line);
    return LineError(path, second,
                     absl::StrCat("the time ", sorted[i].timestamp_ns, " stands in line ", first,
                                  " too: each picture needs a time of its own"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<ListedPicture>> ReadCameraList(const std::string& camera_folder,
                                                          SourceRemarks& remarks) {
  const std::string path = camera_folder + "/data.csv";
  std::vector<ListedPicture> pictures;
  RETURN_IF_ERROR(ForEachLine(path, [&](int line, absl::string_view text) -> absl::Status {
    ASSIGN_OR_RETURN(std::optional<ListedPicture> picture, ParsePicture(path, line, text));
    if (picture.has_value()) pictures.push_back(*std::move(picture));
    return absl::OkStatus();
  }));
  if (!std::is_sorted(pictures.begin(), pictures.end(), IsBefore)) {
    remarks.findings.push_back(
        {FindingLevel::kWarning, "times-out-of-order",
         absl::StrCat(path, ": its times do not grow; it is played in the order of time")});
    std::stable_sort(pictures.begin(), pictures.end(), IsBefore);
  }
  RETURN_IF_ERROR(CheckTimesDiffer(path, pictures));
  return pictures;
}

std::vector<std::pair<ListedPicture, ListedPicture>> PairByTime(
    const std::vector<ListedPicture>& left, const std::vector<ListedPicture>& right,
    int64_t tolerance_ns, SourceRemarks& remarks) {
  std::vector<std::pair<ListedPicture, ListedPicture>> pairs;
  const auto gap_ns = [&](size_t i, size_t k) {
    return std::abs(left[i].timestamp_ns - right[k].timestamp_ns);
  };
  size_t k = 0;
  for (size_t i = 0; i < left.size() && k < right.size(); ++i) {
    while (k + 1 < right.size() && gap_ns(i, k + 1) < gap_ns(i, k)) ++k;
    // The next left picture is nearer to this right one.
    if (i + 1 < left.size() && gap_ns(i + 1, k) < gap_ns(i, k)) continue;
    if (gap_ns(i, k) > tolerance_ns) continue;
    pairs.push_back({left[i], right[k++]});
  }
  const size_t alone = left.size() + right.size() - 2 * pairs.size();
  if (alone == 0) return pairs;
  const std::string text =
      absl::StrCat(left.size() - pairs.size(), " of ", left.size(), " pictures of cam0 and ",
                   right.size() - pairs.size(), " of ", right.size(),
                   " of cam1 have no counterpart within ", tolerance_ns, " ns (?pair-within-ms)");
  remarks.left_out.push_back(text);
  remarks.findings.push_back({FindingLevel::kWarning, "pairs-incomplete", text});
  return pairs;
}

}  // namespace corbslam::client_agent
