#include "services/tool/report/html/held_plots.h"

#include <algorithm>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "services/tool/report/html/report_plots.h"
#include "slam/rendering/svg_plots.h"
#include "slam/rendering/svg_text.h"

namespace corbslam::services {
namespace {

constexpr size_t kMostRobots = 8;
constexpr size_t kMostPoints = 24'000;
constexpr int kWidth_px = 900;

size_t CountKeyframes(const MapPicture& map, bool own) {
  size_t count = 0;
  for (const MapPicture::Robot& robot : map.robots) {
    if (robot.is_own == own) count += robot.keyframes.size();
  }
  return count;
}

std::string NoteOf(const ReportDetail::Held& held) {
  const size_t others = CountKeyframes(held.map, false);
  if (others == 0) return "Nothing of others came to it.";
  return absl::StrCat(CountKeyframes(held.map, true), " keyframes of its own (green) and ", others,
                      " of others (blue).");
}

void AddBar(const std::string& name, const Paint& paint, const std::optional<double>& ate_m,
            BarPlot& plot) {
  if (!ate_m.has_value()) return;
  plot.bars.push_back({name, paint, *ate_m, absl::StrFormat("%.4f", *ate_m)});
}

}  // namespace

std::string HeldPlots(const ReportDetail& detail) {
  const size_t robots = std::min(detail.held.size(), kMostRobots);
  if (robots == 0) return "";
  const size_t points = kMostPoints / (2 * robots);
  std::string figures;
  for (size_t i = 0; i < robots; ++i) {
    const ReportDetail::Held& held = detail.held[i];
    const std::string name = EscapeMarkup(held.robot);
    absl::StrAppend(&figures, Figure(absl::StrCat("The map that ", name, " holds"), NoteOf(held),
                                     FlatMap(held.map, points, kWidth_px)));
    if (!held.nearer.has_value()) continue;
    absl::StrAppend(&figures, Figure(absl::StrCat("The same, nearer: ", name, " among others"),
                                     "Around the keyframe that has the most of others' near it.",
                                     FlatMap(*held.nearer, points, kWidth_px)));
  }
  return absl::StrCat("<div class=\"plots maps\">\n", figures, "</div>\n");
}

std::string CompanyPlots(const RunReport& report) {
  BarPlot plot;
  plot.title = "Absolute error of each robot in the global frame, with company and alone";
  plot.x_label = "absolute error (m)";
  const std::vector<RobotReport>& alone = report.company->alone;
  for (size_t i = 0; i < std::min(report.robots.size(), alone.size()); ++i) {
    const std::string& name = report.robots[i].name;
    AddBar(name + " with company", SeriesPaint(0), report.robots[i].ate_global_m, plot);
    AddBar(name + " alone", SeriesPaint(2), alone[i].ate_global_m, plot);
  }
  if (plot.bars.empty()) return "";
  return absl::StrCat(
      "<div class=\"plots\">\n",
      Figure("Absolute error in the global frame, with company and alone",
             "Of robots that are alone the map is fused, too, and nothing of that is told to them.",
             DrawBarPlot(plot, SvgStyle::kInAPage)),
      "</div>\n");
}

}  // namespace corbslam::services
