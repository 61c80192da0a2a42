#include "client_agent/agent/contradiction_text.h"

#include <cmath>
#include <numbers>

#include "absl/strings/str_format.h"
#include "absl/strings/string_view.h"

namespace corbslam::client_agent {
namespace {

SourceFinding DescribeBend(LocalMapId local_map, const MapBend& bend) {
  return {
      FindingLevel::kWarning, "others-shape",
      absl::StrFormat(
          "local map %s of another robot is bent or torn here: over %.1f m of it this robot's "
          "own sight ends %.2f m beside what that map says, and turned by %.2f degrees against "
          "it. This robot goes on by its own measurements, and takes no points of that map; "
          "the map store adjusts both together. Was the other robot nearly lost here (few "
          "frames, noise, blur, a quick turn)?",
          ToString(local_map), bend.way_m, bend.shift_m, bend.turn_rad * 180 / std::numbers::pi)};
}

}  // namespace

SourceFinding DescribeContradiction(const MapContradiction& found) {
  if (found.bend.has_value()) return DescribeBend(found.local_map, *found.bend);
  const absl::string_view size = found.scale > 1 ? "larger" : "smaller";
  return {
      FindingLevel::kWarning, "others-distances",
      absl::StrFormat(
          "local map %s of another robot is %.2f %% %s than what this robot's camera measures "
          "(standard deviation %.2f %%): one of the two is calibrated wrong, or sees badly. This "
          "robot goes on by its own measurements, and takes no points of that map. Check both "
          "rigs: the baseline, or the depth unit, and the focal length",
          ToString(found.local_map), std::abs(found.scale - 1) * 100, size,
          found.scale_sigma * 100)};
}

}  // namespace corbslam::client_agent
