#include "services/map_store_service/streams/read_timer.h"

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"

namespace corbslam::services {

void ReadTimer::Arm(double seconds, const std::string& what) {
  timer_.Arm(absl::Seconds(seconds), [this, seconds, what] {
    overdue_(
        absl::DeadlineExceededError(absl::StrCat(what, " did not come within ", seconds, " s")));
  });
}

}  // namespace corbslam::services
