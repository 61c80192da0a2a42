#include "tests/fault/network/link_shape.h"

#include "absl/strings/str_cat.h"

namespace corbslam::tests {

absl::Status LinkShape::Validate() const {
  if (!(loss >= 0 && loss < 1)) {
    return absl::InvalidArgumentError(absl::StrCat("loss is ", loss, ", must be in [0, 1)"));
  }
  if (!(rate >= 0)) {
    return absl::InvalidArgumentError(absl::StrCat("rate is ", rate, ", must be at least 0"));
  }
  for (const absl::Duration duration : {delay, outage_begin, outage, up, down}) {
    if (duration >= absl::ZeroDuration()) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("a time is ", absl::FormatDuration(duration), ", must be at least 0"));
  }
  return absl::OkStatus();
}

bool LinkShape::IsUp(absl::Duration since_start) const {
  if (since_start >= outage_begin && since_start < outage_begin + outage) return false;
  if (up <= absl::ZeroDuration() || down <= absl::ZeroDuration()) return true;
  return since_start % (up + down) < up;
}

}  // namespace corbslam::tests
