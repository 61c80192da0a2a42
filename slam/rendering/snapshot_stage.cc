#include <algorithm>
#include <iterator>

#include "absl/strings/str_cat.h"
#include "slam/rendering/map_snapshots.h"
#include "slam/rendering/svg_text.h"

namespace corbslam {
namespace {

constexpr size_t kMostApart = 6;
constexpr double kTitle_px = 44;  // Room for the snapshot's title.
constexpr double kName_px = 26;   // Room for an island's name above it.
constexpr double kScale_px = 30;  // Room for the scale bar below it.
constexpr double kGap_px = 12;
constexpr double kInset_px = 7;  // Between a frame and what stands in it.
constexpr double kLetter_px = 11;

size_t CountKeyframes(const MapPicture& map) {
  size_t count = 0;
  for (const MapPicture::Robot& robot : map.robots) count += robot.keyframes.size();
  return count;
}

double AspectHeight(const Bounds& bounds, double width_px) {
  const Eigen::Vector2d size = bounds.Size();
  return std::clamp(width_px * size.y() / size.x(), 0.25 * width_px, width_px);
}

// Draws an island into a cell, with its name above and a scale bar below.
void DrawIsland(const MapPicture& map, const MapView& view, const Bounds& cell_px,
                Surface& surface) {
  const Bounds area_px{cell_px.low + Eigen::Vector2d(0, kName_px),
                       cell_px.high - Eigen::Vector2d(0, kScale_px)};
  const CellLayout layout = FitCell(view.bounds, area_px);
  DrawMap(map, view.plane_from_world, layout, surface);
  const auto letters = static_cast<size_t>(cell_px.Size().x() / kLetter_px);
  surface.Text(Shorten(map.title, std::max<size_t>(letters, 8)),
               cell_px.low + Eigen::Vector2d(kInset_px, 18), kLetter_px, kInk);
  DrawScaleBar(map.unit, layout, {cell_px.low.x() + kInset_px, cell_px.high.y() - 12}, kLetter_px,
               surface);
}

void DrawFrame(const Bounds& cell_px, Surface& surface) {
  const Eigen::Vector2d& low = cell_px.low;
  const Eigen::Vector2d& high = cell_px.high;
  surface.Path({low, {high.x(), low.y()}, high, {low.x(), high.y()}, low}, kGrid, 1);
}

}  // namespace

void SnapshotStage::Observe(const MapSnapshot& snapshot) {
  for (const MapSnapshot::Island& island : snapshot.islands) {
    const size_t keyframes = CountKeyframes(island.map);
    if (keyframes == 0) continue;
    if (island.is_global) {
      if (!global_.has_value() || keyframes >= global_->keyframes) {
        global_ = {ChooseView(island.map), keyframes};
      }
      continue;
    }
    Place& place = apart_[island.id];
    if (keyframes >= place.keyframes) place = {ChooseView(island.map), keyframes};
  }
}

size_t SnapshotStage::Shown() const { return std::min(apart_.size(), kMostApart); }

double SnapshotStage::GlobalHeight(double width_px) const {
  if (!global_.has_value()) return 0;
  return AspectHeight(global_->view.bounds, width_px) + kName_px + kScale_px;
}

double SnapshotStage::ApartHeight(double width_px) const {
  double height_px = 0;
  const size_t shown = Shown();
  const double cell_px = width_px / std::max(1.0, static_cast<double>(shown));
  for (auto it = apart_.begin(); it != std::next(apart_.begin(), static_cast<ptrdiff_t>(shown));
       ++it) {
    height_px = std::max(height_px, AspectHeight(it->second.view.bounds, cell_px));
  }
  return shown == 0 ? 0 : height_px + kName_px + kScale_px;
}

double SnapshotStage::Height(double width_px) const {
  return kTitle_px + GlobalHeight(width_px) + kGap_px + ApartHeight(width_px);
}

Bounds SnapshotStage::ApartCell(size_t index, const Eigen::Vector2d& low_px,
                                double width_px) const {
  const double cell_px = width_px / static_cast<double>(Shown());
  const double left_px = low_px.x() + static_cast<double>(index) * cell_px;
  const double top_px = low_px.y() + kTitle_px + GlobalHeight(width_px) + kGap_px;
  return {{left_px, top_px}, {left_px + cell_px - kGap_px, top_px + ApartHeight(width_px)}};
}

void SnapshotStage::Draw(const MapSnapshot& snapshot, const Eigen::Vector2d& low_px,
                         double width_px, Surface& surface) const {
  size_t hidden = 0;
  const Bounds global_px{
      low_px + Eigen::Vector2d(0, kTitle_px),
      low_px + Eigen::Vector2d(width_px - kGap_px, kTitle_px + GlobalHeight(width_px))};
  if (global_.has_value()) DrawFrame(global_px, surface);
  for (const MapSnapshot::Island& island : snapshot.islands) {
    if (CountKeyframes(island.map) == 0) continue;
    if (island.is_global) {
      if (global_.has_value()) DrawIsland(island.map, global_->view, global_px, surface);
      continue;
    }
    const auto place = apart_.find(island.id);
    const auto index = static_cast<size_t>(std::distance(apart_.begin(), place));
    if (place == apart_.end() || index >= Shown()) {
      ++hidden;
      continue;
    }
    const Bounds cell_px = ApartCell(index, low_px, width_px);
    DrawFrame(cell_px, surface);
    DrawIsland(island.map, place->second.view, cell_px, surface);
  }
  const std::string more = hidden == 0 ? "" : absl::StrCat(", ", hidden, " more islands not drawn");
  surface.Text(snapshot.title + more, low_px + Eigen::Vector2d(0, 26), 14, kInk);
}

}  // namespace corbslam
