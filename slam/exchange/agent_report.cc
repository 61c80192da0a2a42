#include "slam/exchange/agent_report.h"

#include <cmath>
#include <numbers>

#include "absl/strings/str_format.h"

namespace corbslam {

std::string Describe(const MapContradiction& found) {
  if (found.bend.has_value()) {
    return absl::StrFormat(
        "bent: over %.1f m its camera ends %.2f m beside, turned by %.2f degrees",
        found.bend->way_m, found.bend->shift_m, found.bend->turn_rad * 180 / std::numbers::pi);
  }
  return absl::StrFormat("%.2f %% %s than what its camera measures (+-%.2f %%)",
                         std::abs(found.scale - 1) * 100, found.scale > 1 ? "larger" : "smaller",
                         found.scale_sigma * 100);
}

}  // namespace corbslam
