#include "services/tool/export/mcap/island_layout.h"

#include <algorithm>
#include <optional>

namespace corbslam::services {
namespace {

// At least this far are islands from each other, and at least this share of their widths.
constexpr double kGap = 1.0;
constexpr double kGapShare = 0.2;

struct Range {
  double first = 0;
  double last = 0;
};

Range RangeAlongX(const ToldMap::Island& island) {
  Range range;
  bool is_first = true;
  for (const auto& [id, keyframe] : island.keyframes) {
    const double x = keyframe.island_from_camera.translation.x();
    range = is_first ? Range{x, x} : Range{std::min(range.first, x), std::max(range.last, x)};
    is_first = false;
  }
  return range;
}

}  // namespace

std::map<LocalMapId, Eigen::Vector3d> PlaceIslands(const ToldMap::Islands& islands) {
  std::map<LocalMapId, Eigen::Vector3d> places;
  std::optional<double> taken_until;
  for (const bool in_global_frame : {true, false}) {
    for (const auto& [id, island] : islands) {
      if (island.in_global_frame != in_global_frame) continue;
      const Range range = RangeAlongX(island);
      const double gap = std::max(kGap, kGapShare * (range.last - range.first));
      const bool stays = in_global_frame || !taken_until.has_value();
      const double x = stays ? 0 : *taken_until + gap - range.first;
      places[id] = {x, 0, 0};
      taken_until = std::max(range.last + x, taken_until.value_or(range.last + x));
    }
  }
  return places;
}

}  // namespace corbslam::services
