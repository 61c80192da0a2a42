#include "services/tool/report/html/report_page.h"

#include <openssl/sha.h>

#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "services/tool/report/html/held_plots.h"
#include "services/tool/report/html/page_parts.h"
#include "services/tool/report/html/report_plots.h"
#include "services/tool/report/report_company.h"
#include "services/tool/report/report_tables.h"
#include "slam/rendering/svg_text.h"

namespace corbslam::services {
namespace {

// Returns the source expression by which a policy allows exactly this text.
std::string HashOf(absl::string_view text) {
  unsigned char digest[SHA256_DIGEST_LENGTH];
  SHA256(reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest);
  return absl::StrCat(
      "'sha256-",
      absl::Base64Escape(absl::string_view(reinterpret_cast<const char*>(digest), sizeof(digest))),
      "'");
}

// Returns the page's style, with the colours of all drawings.
std::string Style() {
  return absl::StrCat(":root { ", PaintVariables(/*on_dark=*/false),
                      "}\n@media screen and (prefers-color-scheme: dark) { :root { ",
                      PaintVariables(/*on_dark=*/true), "} }\n", PageStyle());
}

// The frame with the viewer's page inherits the policy.
std::string Policy(const ViewerPage& viewer) {
  const std::string policy = absl::StrCat(
      "default-src 'none'; base-uri 'none'; form-action 'none'; style-src ", HashOf(Style()));
  if (viewer.script.empty()) return policy;
  return absl::StrCat(policy, " ", HashOf(viewer.style), "; script-src ", HashOf(viewer.script));
}

// Paper gets the map from above: what WebGL drew is not kept for printing.
std::string Map(const ReportDetail& detail, const ViewerPage& viewer) {
  const bool is_recorded = !viewer.script.empty() && !detail.recorded.map.empty();
  const std::string frame =
      is_recorded ? ViewerFrame(viewer, detail.recorded, detail.map.truth) : "";
  return absl::StrCat(frame, "<figure", is_recorded ? " class=\"paper\"" : "", ">\n",
                      FlatMap(detail.map), "</figure>\n");
}

std::string ToHtml(const ReportTable& table, const std::string& caption) {
  std::string html =
      absl::StrCat("<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"", caption,
                   "\"><table>\n<caption>", caption, "</caption>\n<thead><tr>");
  for (const std::string& column : table.columns) {
    absl::StrAppend(&html, "<th scope=\"col\">", EscapeMarkup(column), "</th>");
  }
  absl::StrAppend(&html, "</tr></thead>\n<tbody>\n");
  for (const std::vector<std::string>& row : table.rows) {
    absl::StrAppend(&html, "<tr>");
    for (size_t i = 0; i < row.size(); ++i) {
      const char* element = i == 0 ? "th" : "td";
      absl::StrAppend(&html, "<", element, i == 0 ? " scope=\"row\"" : "", ">",
                      EscapeMarkup(row[i]), "</", element, ">");
    }
    absl::StrAppend(&html, "</tr>\n");
  }
  return absl::StrCat(html, "</tbody></table></div>\n");
}

std::string Lines(const std::vector<std::string>& lines) {
  std::string html = "<ul class=\"lines\">\n";
  for (const std::string& line : lines) {
    absl::StrAppend(&html, "<li>", EscapeMarkup(line), "</li>\n");
  }
  return html + "</ul>\n";
}

std::string Warnings(const RunReport& report) {
  const std::vector<ReportWarning> warnings = AllWarnings(report);
  if (warnings.empty()) return "";
  std::vector<std::string> lines;
  for (const ReportWarning& warning : warnings) {
    lines.push_back(absl::StrCat(warning.robot, warning.robot.empty() ? "" : ": ", warning.text,
                                 " [", warning.code, "]"));
  }
  return absl::StrCat(
      "<section class=\"warnings\" aria-labelledby=\"h-warnings\">\n"
      "<h2 id=\"h-warnings\">Warnings</h2>\n",
      Lines(lines), "</section>\n");
}

// What stands on the page, each part with the way to it.
std::string Contents(const RunReport& report, const ReportDetail& detail) {
  const size_t warnings = AllWarnings(report).size();
  std::string html = "<nav class=\"contents\" aria-label=\"Contents\">\n";
  const auto add = [&html](const char* id, const std::string& name, const char* kind = "") {
    absl::StrAppend(&html, "<a href=\"#", id, "\"", kind, ">", name, "</a>\n");
  };
  add("h-map", "The map");
  if (warnings > 0) {
    add("h-warnings", absl::StrCat("Warnings (", warnings, ")"), " class=\"warning\"");
  }
  if (report.company.has_value()) add("h-company", "What company gave");
  if (!detail.held.empty()) add("h-held", "What each robot holds");
  add("h-accuracy", "Accuracy");
  add("h-robots", "The robots");
  add("h-fusion", "Fusing");
  add("h-cost", "What it cost");
  return html + "</nav>\n";
}

// Returns an empty text without figures.
std::string HeldMaps(const ReportDetail& detail) {
  const std::string plots = HeldPlots(detail);
  if (plots.empty()) return "";
  return absl::StrCat(
      "<section aria-labelledby=\"h-held\">\n<h2 id=\"h-held\">What each robot holds</h2>\n"
      "<p class=\"note\">The map in each robot's memory at the end, in its own frame: what it "
      "made, "
      "and what came to it of what others made.</p>\n",
      plots, "</section>\n");
}

// Returns an empty text if the robots did not play alone, too.
std::string Company(const RunReport& report) {
  if (!report.company.has_value()) return "";
  return absl::StrCat(
      "<section aria-labelledby=\"h-company\">\n"
      "<h2 id=\"h-company\">What company gave</h2>\n",
      ToHtml(CompanyTable(report), "The same robots with company, and alone"),
      Lines(CompanyLines(report)), CompanyPlots(report), "</section>\n");
}

// Returns what the map hasn't got; an empty text if that is nothing.
std::string MapNote(const MapPicture& map) {
  if (map.note.empty()) return "";
  return absl::StrCat("<p class=\"warnings\">", EscapeMarkup(map.note), "</p>");
}

// The numbers that are looked for first.
std::string Figures(const RunReport& report) {
  const FusedReport& fused = report.fused;
  const std::string ate = fused.ate_m.has_value() ? FormatOr(fused.ate_m, 3) + " m" : "-";
  const std::string drift =
      fused.t_rel_percent.has_value() ? FormatOr(fused.t_rel_percent, 2) + " %" : "-";
  const std::pair<const char*, std::string> figures[] = {
      {"robots in the map", absl::StrCat(fused.robots, " of ", report.robots.size())},
      {"islands", absl::StrCat(fused.islands)},
      {"keyframes", absl::StrCat(fused.keyframes)},
      {"map points", absl::StrCat(fused.map_points)},
      {"absolute error", ate},
      {"relative error", drift},
      {"took", absl::StrFormat("%.0f s", report.wall_s)}};
  std::string html;
  for (const auto& [name, value] : figures) {
    absl::StrAppend(&html, "<div><dt>", name, "</dt><dd>", value, "</dd></div>\n");
  }
  return html;
}

std::string About(const RunReport& report) {
  std::string about = absl::StrCat("Mission ", report.mission, ", pace ", report.pace);
  for (const RobotReport& robot : report.robots) {
    absl::StrAppend(&about, robot.name == report.robots.front().name ? ": " : "; ", robot.name,
                    " saw ", robot.source);
  }
  return EscapeMarkup(about);
}

std::string Cost(const RunReport& report) {
  std::string html = ToHtml(TransferTable(report), "What the robots sent to the store");
  const ReportTable servers = ServerTable(report);
  if (!servers.rows.empty()) absl::StrAppend(&html, ToHtml(servers, "Servers"));
  const std::string line = CostLine(report);
  if (!line.empty()) absl::StrAppend(&html, "<p>", EscapeMarkup(line), "</p>\n");
  return html;
}

}  // namespace

std::string ToHtml(const RunReport& report, const ReportDetail& detail, const ViewerPage& viewer) {
  const std::string fusion = absl::StrCat(ToHtml(FusedTable(report), "The fused map"),
                                          Lines(FusionLines(report)), FusionPlots(report));
  // Each part is put in once: braces in what is put in mean nothing.
  return absl::StrReplaceAll(
      PageTemplate(),
      {{"{{policy}}", Policy(viewer)},
       {"{{title}}", EscapeMarkup(absl::StrCat("Mission ", report.mission, ": corbslam run"))},
       {"{{style}}", Style()},
       {"{{about}}", About(report)},
       {"{{figures}}", Figures(report)},
       {"{{contents}}", Contents(report, detail)},
       {"{{warnings}}", Warnings(report)},
       {"{{map_note}}", MapNote(detail.map)},
       {"{{map}}", Map(detail, viewer)},
       {"{{company}}", Company(report)},
       {"{{held}}", HeldMaps(detail)},
       {"{{accuracy}}", AccuracyPlots(detail)},
       {"{{robots}}",
        absl::StrCat(ToHtml(RobotTable(report), "Each robot"), RobotPlots(report, detail))},
       {"{{fusion}}", fusion},
       {"{{cost}}", Cost(report)},
       {"{{made}}",
        EscapeMarkup(absl::StrFormat("corbslam %s, %.1f s. report.json beside this page "
                                     "holds the numbers for programs.",
                                     report.version, report.wall_s))},
       {"{{command}}", EscapeMarkup(report.command)}});
}

}  // namespace corbslam::services
