#include "services/programs/robot/map_wait.h"

#include <glog/logging.h>

#include "absl/time/clock.h"

namespace corbslam::services {

using client_agent::UplinkHold;

namespace {

constexpr absl::Duration kPoll = absl::Milliseconds(20);

}  // namespace

void WaitForMap(const client_agent::Agent& agent, const std::string& mission,
                const absl::Notification& stop, const MapWaitOptions& options) {
  const absl::Time begin = absl::Now();
  bool is_said = false;
  do {
    const UplinkHold hold = agent.GetStatus().upload.hold;
    const absl::Duration waited = absl::Now() - begin;
    const bool is_opening = hold == UplinkHold::kOpening;
    if (!is_opening && hold != UplinkHold::kAway) {
      if (is_said) LOG(INFO) << "mission " << mission << ": waited " << absl::Trunc(waited, kPoll);
      return;
    }
    if (waited > (is_opening ? options.opening : options.away)) return;
    if (is_said || waited < options.quiet) continue;
    is_said = true;
    LOG(INFO) << (is_opening ? "the map store opens mission " : "no map store answers for mission ")
              << mission
              << (is_opening ? "; if it was asleep it wakes now, which is to be read from the disk"
                             : "")
              << ": the first frame waits for the map";
  } while (!stop.WaitForNotificationWithTimeout(kPoll));
}

}  // namespace corbslam::services
