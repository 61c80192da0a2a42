#include "slam/rendering/map_legend.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "slam/rendering/map_cell.h"
#include "slam/rendering/svg_text.h"

namespace corbslam {
namespace {

constexpr double kTitleLine_px = 30;  // Base line of the title.
constexpr double kApart_px = 32;      // Between two entries.
constexpr double kSign_px = 20;       // What a sign takes.
constexpr double kTruthSign_px = 46;

double SignWidth(MapLegend::Sign sign) {
  return sign == MapLegend::Sign::kTruth ? kTruthSign_px : kSign_px;
}

// Returns `text` with `end` behind it, of the text as many letters as fit.
std::string Fit(const std::string& text, const std::string& end, double room_px, double letter_px,
                const Surface& measure) {
  std::string fitting = text;
  for (size_t letters = CountCharacters(text);
       letters > 1 && measure.TextWidth(fitting + end, letter_px) > room_px;) {
    fitting = Shorten(text, --letters);
  }
  return fitting + end;
}

// Breaks between words.
std::vector<std::string> BreakLines(const std::string& text, double room_px, double letter_px,
                                    const Surface& measure) {
  std::vector<std::string> lines;
  for (const absl::string_view word : absl::StrSplit(text, ' ', absl::SkipEmpty())) {
    const std::string longer =
        lines.empty() ? std::string(word) : absl::StrCat(lines.back(), " ", word);
    if (!lines.empty() && measure.TextWidth(longer, letter_px) <= room_px) {
      lines.back() = longer;
    } else {
      lines.emplace_back(word);
    }
  }
  for (std::string& line : lines) line = Fit(line, "", room_px, letter_px, measure);
  return lines;
}

struct Label {
  MapLegend::Sign sign;
  std::string text;
  std::string end;
};

// Adds the entry of own or of others' robots, if there are any.
void AddRobots(const MapPicture& picture, bool own, std::vector<Label>& labels) {
  std::string names;
  size_t keyframes = 0;
  for (const MapPicture::Robot& robot : picture.robots) {
    if (robot.is_own != own) continue;
    absl::StrAppend(&names, names.empty() ? "" : ", ", robot.name);
    keyframes += robot.keyframes.size();
  }
  if (names.empty()) return;
  labels.push_back({own ? MapLegend::Sign::kOwn : MapLegend::Sign::kOthers,
                    (own ? "own keyframes: " : "others' keyframes: ") + names,
                    absl::StrCat(" (", keyframes, ")")});
}

std::vector<Label> LabelsOf(const MapPicture& picture, size_t points) {
  std::vector<Label> labels;
  AddRobots(picture, true, labels);
  AddRobots(picture, false, labels);
  const size_t total = std::max(picture.all_points, picture.points.size());
  const std::string of = points == total ? "" : absl::StrCat(" of ", total);
  labels.push_back({MapLegend::Sign::kPoint, "map points", absl::StrCat(" (", points, of, ")")});
  if (!picture.truth.empty()) labels.push_back({MapLegend::Sign::kTruth, "truth", ""});
  return labels;
}

void DrawSign(const MapLegend::Entry& entry, Surface& surface) {
  const Eigen::Vector2d& at_px = entry.at_px;
  switch (entry.sign) {
    case MapLegend::Sign::kOwn:
      surface.FilledPolygon(KeyframeShape(at_px, {1, 0}), kOwn, kOwn);
      return;
    case MapLegend::Sign::kOthers:
      surface.FilledPolygon(KeyframeShape(at_px, {1, 0}), kOthers, kOthers);
      return;
    case MapLegend::Sign::kPoint:
      surface.Discs({at_px + Eigen::Vector2d(6, 0)}, 2.5, kInk);
      return;
    case MapLegend::Sign::kTruth:
      surface.DashedPath({at_px, at_px + Eigen::Vector2d(36, 0)}, kTruth, 2, 8, 5);
  }
}

}  // namespace

MapLegend ArrangeLegend(const MapPicture& picture, size_t points, double width_px,
                        const Surface& measure) {
  MapLegend legend;
  legend.letter_px = std::clamp(width_px / 50, 8.0, 14.0);
  const double line_px = 1.7 * legend.letter_px;
  const double room_px = width_px - 1.5 * kMapMargin_px;
  legend.title = Fit(picture.title, "", room_px, legend.letter_px + 2, measure);
  Eigen::Vector2d at_px(kMapMargin_px, kTitleLine_px + line_px);
  for (const Label& label : LabelsOf(picture, points)) {
    const double sign_px = SignWidth(label.sign);
    const std::string text =
        Fit(label.text, label.end, room_px - sign_px, legend.letter_px, measure);
    const double entry_px = sign_px + measure.TextWidth(text, legend.letter_px);
    if (at_px.x() > kMapMargin_px && at_px.x() + entry_px > kMapMargin_px + room_px) {
      at_px = {kMapMargin_px, at_px.y() + line_px};
    }
    legend.entries.push_back({label.sign, text, at_px});
    at_px.x() += entry_px + kApart_px;
  }
  legend.header_px = at_px.y() + kTitleLine_px;
  if (picture.note.empty()) return legend;
  legend.note = BreakLines(picture.note, room_px, legend.letter_px, measure);
  legend.note_px = static_cast<double>(legend.note.size()) * line_px;
  return legend;
}

void DrawLegend(const MapLegend& legend, double bottom_px, Surface& surface) {
  surface.Text(legend.title, {kMapMargin_px, kTitleLine_px}, legend.letter_px + 2, kInk);
  for (const MapLegend::Entry& entry : legend.entries) {
    DrawSign(entry, surface);
    const Eigen::Vector2d text_px(SignWidth(entry.sign), 0.36 * legend.letter_px);
    surface.Text(entry.label, entry.at_px + text_px, legend.letter_px, kInk);
  }
  double y_px = bottom_px - legend.note_px;
  for (const std::string& line : legend.note) {
    y_px += legend.note_px / static_cast<double>(legend.note.size());
    surface.Text(line, {kMapMargin_px, y_px}, legend.letter_px, kTruth);
  }
}

}  // namespace corbslam
