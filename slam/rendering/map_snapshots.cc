#include "slam/rendering/map_snapshots.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "slam/rendering/canvas.h"
#include "slam/rendering/svg_surface.h"

namespace corbslam {
namespace {

constexpr size_t kMostInARow = 4;
constexpr double kMargin_px = 20;
constexpr double kLegend_px = 34;
constexpr double kLetter_px = 11;

// Snapshots in rows below a legend.
struct Grid {
  size_t columns = 1;
  double cell_width_px = 0;
  double cell_height_px = 0;
  int height_px = 0;
};

Grid Arrange(const SnapshotStage& stage, size_t snapshots, int width_px) {
  Grid grid;
  grid.columns = std::clamp<size_t>(snapshots, 1, kMostInARow);
  grid.cell_width_px = (width_px - 2 * kMargin_px) / static_cast<double>(grid.columns);
  grid.cell_height_px = stage.Height(grid.cell_width_px);
  const auto rows =
      static_cast<double>((std::max<size_t>(snapshots, 1) + grid.columns - 1) / grid.columns);
  grid.height_px =
      static_cast<int>(std::ceil(kLegend_px + rows * grid.cell_height_px + kMargin_px));
  return grid;
}

bool ShowsTruth(const MapSnapshot& snapshot) {
  return std::ranges::any_of(snapshot.islands, [](const MapSnapshot::Island& island) {
    return !island.map.truth.empty();
  });
}

double DrawEntry(const std::string& label, double x_px, Surface& surface) {
  surface.Text(label, {x_px + 20, 24}, kLetter_px, kInk);
  return x_px + 20 + surface.TextWidth(label, kLetter_px) + 26;
}

void DrawKeys(const MapSnapshot& snapshot, Surface& surface) {
  double x_px = kMargin_px;
  for (const auto& [label, paint] :
       {std::pair("own keyframes", kOwn), {"others' keyframes", kOthers}}) {
    surface.FilledPolygon(KeyframeShape({x_px, 19}, {1, 0}), paint, paint);
    x_px = DrawEntry(label, x_px, surface);
  }
  surface.Discs({{x_px + 6, 19}}, 2.5, kInk);
  x_px = DrawEntry("map points", x_px, surface);
  if (!ShowsTruth(snapshot)) return;
  surface.DashedPath({{x_px - 8, 19}, {x_px + 14, 19}}, kTruth, 2, 8, 5);
  DrawEntry("truth", x_px, surface);
}

void Draw(const std::vector<MapSnapshot>& snapshots, const SnapshotStage& stage, const Grid& grid,
          Surface& surface) {
  DrawKeys(snapshots.back(), surface);
  for (size_t i = 0; i < snapshots.size(); ++i) {
    const Eigen::Vector2d low_px(
        kMargin_px + static_cast<double>(i % grid.columns) * grid.cell_width_px,
        kLegend_px + static_cast<double>(i / grid.columns) * grid.cell_height_px);
    stage.Draw(snapshots[i], low_px, grid.cell_width_px, surface);
  }
}

absl::StatusOr<SnapshotStage> MakeStage(const std::vector<MapSnapshot>& snapshots, int width_px) {
  if (width_px < 200 || width_px > 10'000) {
    return absl::InvalidArgumentError(absl::StrCat("width_px ", width_px, " is not 200 to 10000"));
  }
  SnapshotStage stage;
  for (const MapSnapshot& snapshot : snapshots) stage.Observe(snapshot);
  if (stage.is_empty()) return absl::InvalidArgumentError("the map has no keyframes");
  return stage;
}

absl::StatusOr<cv::Mat> DrawOnCanvas(const std::vector<MapSnapshot>& snapshots,
                                     const SnapshotStage& stage, int width_px) {
  const Grid grid = Arrange(stage, snapshots.size(), width_px);
  try {
    Canvas canvas(width_px, grid.height_px);
    Draw(snapshots, stage, grid, canvas);
    return canvas.Finish();
  } catch (const cv::Exception& exception) {
    return absl::InternalError(absl::StrCat("drawing the map: ", exception.what()));
  }
}

}  // namespace

absl::StatusOr<cv::Mat> RenderSnapshots(const std::vector<MapSnapshot>& snapshots,
                                        const SnapshotOptions& options) {
  const absl::StatusOr<SnapshotStage> stage = MakeStage(snapshots, options.width_px);
  if (!stage.ok()) return stage.status();
  return DrawOnCanvas(snapshots, *stage, options.width_px);
}

absl::StatusOr<std::string> RenderSnapshotsSvg(const std::vector<MapSnapshot>& snapshots,
                                               const SnapshotOptions& options) {
  const absl::StatusOr<SnapshotStage> stage = MakeStage(snapshots, options.width_px);
  if (!stage.ok()) return stage.status();
  const Grid grid = Arrange(*stage, snapshots.size(), options.width_px);
  SvgSurface surface(options.width_px, grid.height_px, SvgLook::kAlone);
  Draw(snapshots, *stage, grid, surface);
  const std::string titles = absl::StrJoin(
      snapshots, "; ",
      [](std::string* text, const MapSnapshot& snapshot) { text->append(snapshot.title); });
  return surface.Finish(absl::StrCat("The map at: ", titles));
}

absl::StatusOr<cv::Mat> RenderFrame(const SnapshotStage& stage, const MapSnapshot& snapshot,
                                    const SnapshotOptions& options) {
  return DrawOnCanvas({snapshot}, stage, options.width_px);
}

}  // namespace corbslam
