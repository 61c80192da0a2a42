#include "client_agent/agent/others_words.h"

#include <cmath>

#include "absl/strings/str_format.h"
#include "absl/strings/string_view.h"

namespace corbslam::client_agent {

SourceFinding DescribeContradiction(const ScaleContradiction& found) {
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
