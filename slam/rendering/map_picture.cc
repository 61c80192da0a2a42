#include "slam/rendering/map_picture.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "slam/rendering/canvas.h"
#include "slam/rendering/map_cell.h"
#include "slam/rendering/map_legend.h"
#include "slam/util/atomic_file.h"

namespace corbslam {
namespace {

constexpr double kFooter_px = 56;

struct PictureLayout {
  CellLayout cell;
  MapLegend legend;
  int height_px = 0;
};

// The map is at most as high as wide; one that is higher is centred.
PictureLayout ArrangePicture(const MapPicture& picture, const MapView& view, int width_px,
                             const Surface& measure) {
  const double plot_px = width_px - 2 * kMapMargin_px;
  const Eigen::Vector2d size = view.bounds.Size();
  const double plot_height_px = size.y() * plot_px / size.maxCoeff();
  PictureLayout layout;
  layout.cell =
      FitCell(view.bounds, {{kMapMargin_px, 0}, {kMapMargin_px + plot_px, plot_height_px}});
  const size_t points = CountSeen(picture.points, view.plane_from_world, layout.cell.bounds);
  layout.legend = ArrangeLegend(picture, points, width_px, measure);
  layout.cell.origin_px.y() = layout.legend.header_px;
  layout.height_px = static_cast<int>(
      std::ceil(layout.legend.header_px + plot_height_px + kFooter_px + layout.legend.note_px));
  return layout;
}

void Draw(const MapPicture& picture, const MapView& view, const PictureLayout& layout,
          Surface& surface) {
  DrawMap(picture, view.plane_from_world, layout.cell, surface);
  const double below_px = layout.height_px - layout.legend.note_px;
  DrawScaleBar(picture.unit, layout.cell, {kMapMargin_px, below_px - 24}, layout.legend.letter_px,
               surface);
  DrawLegend(layout.legend, layout.height_px - 12.0, surface);
}

absl::Status Check(const MapPicture& picture, const MapPictureOptions& options) {
  if (options.width_px < 200 || options.width_px > 10'000) {
    return absl::InvalidArgumentError(
        absl::StrCat("width_px ", options.width_px, " is not 200 to 10000"));
  }
  const bool is_empty = std::ranges::all_of(
      picture.robots, [](const MapPicture::Robot& robot) { return robot.keyframes.empty(); });
  if (is_empty) return absl::InvalidArgumentError("the map has no keyframes");
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<cv::Mat> RenderMap(const MapPicture& picture, const MapPictureOptions& options) {
  if (const absl::Status status = Check(picture, options); !status.ok()) return status;
  const MapView view = ChooseView(picture);
  try {
    const PictureLayout layout = ArrangePicture(picture, view, options.width_px, Canvas(1, 1));
    Canvas canvas(options.width_px, layout.height_px);
    Draw(picture, view, layout, canvas);
    return canvas.Finish();
  } catch (const cv::Exception& exception) {
    return absl::InternalError(absl::StrCat("drawing the map: ", exception.what()));
  }
}

absl::StatusOr<std::string> RenderMapSvg(const MapPicture& picture, SvgStyle style,
                                         const MapPictureOptions& options) {
  if (const absl::Status status = Check(picture, options); !status.ok()) return status;
  const MapView view = ChooseView(picture);
  const PictureLayout layout =
      ArrangePicture(picture, view, options.width_px, SvgSurface(1, 1, style));
  SvgSurface surface(options.width_px, layout.height_px, style);
  Draw(picture, view, layout, surface);
  return surface.Finish(picture.title);
}

absl::Status WriteImage(const cv::Mat& image, const std::string& path) {
  const std::string ending =
      absl::AsciiStrToLower(std::filesystem::path(path).extension().string());
  std::vector<uint8_t> bytes;
  try {
    if (!cv::imencode(ending, image, bytes)) bytes.clear();
  } catch (const cv::Exception&) {
    bytes.clear();
  }
  if (bytes.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "can't write ", path, ": no kind of picture ends with '", ending, "', .png is one"));
  }
  return WriteAtomically(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace corbslam
