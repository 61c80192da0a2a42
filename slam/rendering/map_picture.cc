#include "slam/rendering/map_picture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "absl/strings/str_cat.h"
#include "slam/rendering/canvas.h"
#include "slam/rendering/map_cell.h"
#include "slam/rendering/map_legend.h"

namespace corbslam {
namespace {

constexpr double kFooter_px = 56;
constexpr double kLetter_px = 14;

struct PictureLayout {
  CellLayout cell;
  int height_px = 0;
};

// The map is at most as high as wide; one that is higher is centred.
PictureLayout ArrangePicture(const Bounds& bounds, int width_px) {
  const double plot_px = width_px - 2 * kMapMargin_px;
  const Eigen::Vector2d size = bounds.Size();
  const double px_per_unit = plot_px / size.maxCoeff();
  const Eigen::Vector2d low_px(kMapMargin_px, kMapHeader_px);
  PictureLayout layout;
  layout.cell =
      FitCell(bounds, {low_px, low_px + Eigen::Vector2d(plot_px, size.y() * px_per_unit)});
  layout.height_px =
      static_cast<int>(std::ceil(size.y() * px_per_unit + kMapHeader_px + kFooter_px));
  return layout;
}

void Draw(const MapPicture& picture, const MapView& view, const PictureLayout& layout,
          Surface& surface) {
  DrawMap(picture, view.plane_from_world, layout.cell, surface);
  DrawLegend(picture, surface);
  DrawScaleBar(picture.unit, layout.cell, {kMapMargin_px, layout.height_px - 24.0}, kLetter_px,
               surface);
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
  const PictureLayout layout = ArrangePicture(view.bounds, options.width_px);
  try {
    Canvas canvas(options.width_px, layout.height_px);
    Draw(picture, view, layout, canvas);
    return canvas.Finish();
  } catch (const cv::Exception& exception) {
    return absl::InternalError(absl::StrCat("drawing the map: ", exception.what()));
  }
}

absl::StatusOr<std::string> RenderMapSvg(const MapPicture& picture, SvgLook look,
                                         const MapPictureOptions& options) {
  if (const absl::Status status = Check(picture, options); !status.ok()) return status;
  const MapView view = ChooseView(picture);
  const PictureLayout layout = ArrangePicture(view.bounds, options.width_px);
  SvgSurface surface(options.width_px, layout.height_px, look);
  Draw(picture, view, layout, surface);
  return surface.Finish(picture.title);
}

absl::Status WritePng(const cv::Mat& image, const std::string& path) {
  try {
    if (cv::imwrite(path, image)) return absl::OkStatus();
  } catch (const cv::Exception& exception) {
    return absl::UnavailableError(absl::StrCat("cannot write ", path, ": ", exception.what()));
  }
  return absl::UnavailableError(absl::StrCat("cannot write ", path));
}

}  // namespace corbslam
