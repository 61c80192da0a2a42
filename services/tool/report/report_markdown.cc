#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "services/tool/report/report.h"
#include "services/tool/report/report_company.h"
#include "services/tool/report/report_tables.h"

namespace corbslam::services {
namespace {

std::string Row(const std::vector<std::string>& cells) {
  return absl::StrCat("| ", absl::StrJoin(cells, " | "), " |\n");
}

std::string ToMarkdown(const ReportTable& table) {
  std::string text =
      absl::StrCat(Row(table.columns), Row(std::vector<std::string>(table.columns.size(), "---")));
  for (const std::vector<std::string>& row : table.rows) absl::StrAppend(&text, Row(row));
  return text;
}

std::string FusionList(const RunReport& report) {
  std::string list;
  for (const std::string& line : FusionLines(report)) absl::StrAppend(&list, "* ", line, "\n");
  return list;
}

// Returns an empty text if no server is known.
std::string Servers(const RunReport& report) {
  const ReportTable table = ServerTable(report);
  return table.rows.empty() ? "" : absl::StrCat("\n", ToMarkdown(table));
}

std::string Cost(const RunReport& report) {
  const std::string line = CostLine(report);
  return line.empty() ? "" : absl::StrCat("\n", line, "\n");
}

// Returns an empty text if the robots did not play alone, too.
std::string Company(const RunReport& report) {
  if (!report.company.has_value()) return "";
  std::string text =
      absl::StrCat("\n## What company gave\n\n", ToMarkdown(CompanyTable(report)), "\n");
  for (const std::string& line : CompanyLines(report)) absl::StrAppend(&text, "* ", line, "\n");
  return text;
}

// Returns a line for each warning; an empty text if there is none.
std::string WarningList(const RunReport& report) {
  const std::vector<ReportWarning> warnings = AllWarnings(report);
  if (warnings.empty()) return "";
  std::string list = "\nWarnings:\n\n";
  for (const ReportWarning& warning : warnings) {
    const std::string who = warning.robot.empty() ? "" : absl::StrCat(warning.robot, ": ");
    absl::StrAppend(&list, "* ", who, absl::StrReplaceAll(warning.text, {{"\n", " "}}), " [",
                    warning.code, "]\n");
  }
  return list;
}

}  // namespace

std::string ToMarkdown(const RunReport& report) {
  return absl::StrCat(
      "# Several robots, one map\n\n", ToMarkdown(RobotTable(report)), WarningList(report),
      "\nThe fused map:\n\n", ToMarkdown(FusedTable(report)), "\n", FusionList(report), "\n",
      ToMarkdown(TransferTable(report)), Servers(report), Cost(report), Company(report),
      absl::StrFormat("\nMission %s, pace %s, %.1f s, corbslam %s\n\n    %s\n", report.mission,
                      report.pace, report.wall_s, report.version, report.command));
}

}  // namespace corbslam::services
