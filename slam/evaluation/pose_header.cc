#include "slam/evaluation/pose_header.h"

#include <cstddef>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"

namespace corbslam {
namespace {

// Turns "q_RS_w []" into "qrsw".
std::string ColumnName(absl::string_view text) {
  const std::string name = absl::AsciiStrToLower(absl::StripAsciiWhitespace(text));
  return absl::StrReplaceAll(name.substr(0, name.find_first_of(" [(")), {{"_", ""}, {"#", ""}});
}

}  // namespace

void ReadPoseHeader(absl::string_view comment, PoseHeader& header) {
  for (const PosesOf poses_of :
       {PosesOf::kRecordedCamera, PosesOf::kRectifiedCamera, PosesOf::kBody}) {
    if (absl::StrContains(comment, PoseHeaderLine(poses_of))) header.poses_of = poses_of;
  }
  const bool has_commas = absl::StrContains(comment, ',');
  const std::vector<absl::string_view> columns =
      absl::StrSplit(comment, absl::ByAnyChar(has_commas ? "," : " \t"), absl::SkipEmpty());
  std::optional<size_t> w;
  std::optional<size_t> x;
  for (size_t i = 0; i < columns.size(); ++i) {
    const std::string name = ColumnName(columns[i]);
    if (!absl::StartsWith(name, "q")) continue;
    if (absl::EndsWith(name, "w")) w = i;
    if (absl::EndsWith(name, "x")) x = i;
  }
  if (w.has_value() && x.has_value()) header.is_w_first = *w < *x;
}

std::string PoseHeaderLine(PosesOf poses_of) {
  return absl::StrCat("poses of ", Describe(poses_of));
}

}  // namespace corbslam
