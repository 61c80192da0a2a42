// Waits with a robot's first frame for the map that it only localises in.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_MAP_WAIT_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_MAP_WAIT_H_

#include <string>

#include "absl/synchronization/notification.h"
#include "absl/time/time.h"
#include "client_agent/agent/agent.h"

namespace corbslam::services {

struct MapWaitOptions {
  // So long for a store that opens the mission: one that sleeps is read from the disk.
  absl::Duration opening = absl::Seconds(60);
  // So long for one that does not answer.
  absl::Duration away = absl::Seconds(5);
  // The log says what is waited for once it has taken so long.
  absl::Duration quiet = absl::Milliseconds(500);
};

// Returns when a session stands, was refused, or does not come in time, or when `stop` is notified:
// every frame before would be lost.
void WaitForMap(const client_agent::Agent& agent, const std::string& mission,
                const absl::Notification& stop, const MapWaitOptions& options = {});

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_MAP_WAIT_H_
