#include "slam/rendering/svg_surface.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "slam/rendering/svg_text.h"

namespace corbslam {
namespace {

// Further out nobody sees anything, and readers of SVG compute in single precision.
constexpr double kFarthest_px = 1e5;
// A capital letter's share of the font's size, and a letter's mean width, of common sans-serifs.
constexpr double kCapital = 0.72;
constexpr double kLetterWidth = 0.56;

bool IsDrawable(const Surface::Point& x) {
  return x.allFinite() && x.cwiseAbs().maxCoeff() <= kFarthest_px;
}

std::string Number(double number) { return FormatShort(number, 1); }

// A point between two gaps is a line of no length, which round ends make a dot.
std::string PathData(const std::vector<Surface::Point>& path) {
  std::string data;
  size_t points = 0;  // How many the current stretch has.
  const auto end_stretch = [&] {
    if (points == 1) absl::StrAppend(&data, "h0");
    points = 0;
  };
  for (const Surface::Point& x : path) {
    if (!IsDrawable(x)) {
      end_stretch();
      continue;
    }
    absl::StrAppend(&data, points > 0 ? "L" : "M", Number(x.x()), " ", Number(x.y()));
    ++points;
  }
  end_stretch();
  return data;
}

const char* AnchorName(Anchor anchor) {
  switch (anchor) {
    case Anchor::kStart:
      return "start";
    case Anchor::kMiddle:
      return "middle";
    case Anchor::kEnd:
      break;
  }
  return "end";
}

}  // namespace

SvgSurface::SvgSurface(double width_px, double height_px, SvgStyle style)
    : width_px_(width_px), height_px_(height_px), style_(style) {}

std::string SvgSurface::Colour(const Paint& paint) const {
  if (style_ == SvgStyle::kInAPage && paint.variable != nullptr) {
    return absl::StrCat("var(--", paint.variable, ")");
  }
  return absl::StrFormat("#%02x%02x%02x", paint.red, paint.green, paint.blue);
}

void SvgSurface::Stroke(const std::vector<Point>& path, const Paint& paint, double width_px,
                        const std::string& attributes) {
  const std::string data = PathData(path);
  if (data.empty()) return;
  absl::StrAppend(&body_, "<path d=\"", data, "\" fill=\"none\" stroke=\"", Colour(paint),
                  "\" stroke-width=\"", Number(width_px), "\"", attributes, "/>\n");
}

void SvgSurface::Line(const Point& from, const Point& to, const Paint& paint, double width_px) {
  if (IsDrawable(from) && IsDrawable(to)) Stroke({from, to}, paint, width_px, "");
}

void SvgSurface::Path(const std::vector<Point>& path, const Paint& paint, double width_px) {
  Stroke(path, paint, width_px, " stroke-linejoin=\"round\" stroke-linecap=\"round\"");
}

void SvgSurface::DashedPath(const std::vector<Point>& path, const Paint& paint, double width_px,
                            double dash_px, double gap_px) {
  Stroke(path, paint, width_px,
         absl::StrCat(" stroke-dasharray=\"", Number(dash_px), " ", Number(gap_px), "\""));
}

// Discs are the round ends of lines of no length: a tenth of what circles take.
void SvgSurface::Discs(const std::vector<Point>& centres, double radius_px, const Paint& paint) {
  std::string data;
  for (const Point& x : centres) {
    if (IsDrawable(x)) absl::StrAppend(&data, "M", Number(x.x()), " ", Number(x.y()), "h0");
  }
  if (data.empty()) return;
  absl::StrAppend(&body_, "<path d=\"", data, "\" fill=\"none\" stroke=\"", Colour(paint),
                  "\" stroke-width=\"", Number(2 * radius_px), "\" stroke-linecap=\"round\"/>\n");
}

void SvgSurface::FilledPolygon(const std::vector<Point>& corners, const Paint& paint,
                               const Paint& outline) {
  for (const Point& x : corners) {
    if (!IsDrawable(x)) return;
  }
  absl::StrAppend(&body_, "<path d=\"", PathData(corners), "Z\" fill=\"", Colour(paint),
                  "\" stroke=\"", Colour(outline), "\" stroke-width=\"0.5\"/>\n");
}

void SvgSurface::Text(const std::string& text, const Point& at, double height_px,
                      const Paint& paint, Anchor anchor) {
  if (!IsDrawable(at)) return;
  absl::StrAppend(&body_, "<text x=\"", Number(at.x()), "\" y=\"", Number(at.y()),
                  "\" font-size=\"", Number(height_px / kCapital), "\" fill=\"", Colour(paint),
                  "\" text-anchor=\"", AnchorName(anchor), "\">", EscapeMarkup(text), "</text>\n");
}

double SvgSurface::TextWidth(const std::string& text, double height_px) const {
  return static_cast<double>(CountCharacters(text)) * kLetterWidth * height_px / kCapital;
}

std::string SvgSurface::Finish(const std::string& title) const {
  const std::string size =
      absl::StrCat("viewBox=\"0 0 ", Number(width_px_), " ", Number(height_px_), "\" role=\"img\"");
  const std::string name = EscapeMarkup(title);
  if (style_ == SvgStyle::kInAPage) {
    return absl::StrCat("<svg ", size, " aria-label=\"", name, "\">\n", body_, "</svg>\n");
  }
  return absl::StrCat("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"", Number(width_px_),
                      "\" height=\"", Number(height_px_), "\" ", size,
                      " font-family=\"sans-serif\">\n<title>", name,
                      "</title>\n<rect width=\"100%\" height=\"100%\" fill=\"", Colour(kPaper),
                      "\"/>\n", body_, "</svg>\n");
}

}  // namespace corbslam
