#include "services/programs/robot/inspected_source.h"

#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client_agent/source_checks/source_checks.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::DescribeInLines;
using client_agent::FindingLevel;
using client_agent::FrameReader;
using client_agent::InspectSource;
using client_agent::OpenReader;
using client_agent::PlayReader;
using client_agent::SourceDescription;
using client_agent::SourceFinding;
using client_agent::SourceFindings;
using client_agent::SourceSpec;

absl::Status JudgeFindings(const SourceFindings& findings, bool strict) {
  std::vector<std::string> wrong;
  for (const SourceFinding& finding : findings) {
    if (finding.level != FindingLevel::kError && !strict) continue;
    wrong.push_back(absl::StrCat(finding.text, " [", finding.code, "]"));
  }
  if (wrong.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrJoin(wrong, "\n"));
}

absl::StatusOr<InspectedSource> OpenInspectedSource(const SourceSpec& spec, bool strict) {
  ASSIGN_OR_RETURN(std::unique_ptr<FrameReader> reader, OpenReader(spec));
  InspectedSource opened;
  opened.warnings = InspectSource(*reader, spec);
  RETURN_IF_ERROR(JudgeFindings(opened.warnings, strict));
  opened.description = reader->description();
  ASSIGN_OR_RETURN(opened.source, PlayReader(std::move(reader), spec));
  return opened;
}

std::string FormatDescription(const SourceDescription& description) {
  std::vector<std::string> lines;
  for (const auto& [name, value] : DescribeInLines(description)) {
    lines.push_back(absl::StrCat("  ", name, ": ", value));
  }
  return absl::StrJoin(lines, "\n");
}

}  // namespace corbslam::services
