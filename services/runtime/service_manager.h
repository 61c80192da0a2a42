// Tells the service manager that started this process (systemd) how it is.
#ifndef CORBSLAM_SERVICES_RUNTIME_SERVICE_MANAGER_H_
#define CORBSLAM_SERVICES_RUNTIME_SERVICE_MANAGER_H_

#include "absl/strings/string_view.h"
#include "absl/time/time.h"

namespace corbslam::services {

// Sends lines as "READY=1" or "WATCHDOG=1" to the socket that NOTIFY_SOCKET names (sd_notify(3)).
// Returns false where nobody listens, which is no error.
bool NotifyServiceManager(absl::string_view lines);

// Returns within which time a "WATCHDOG=1" must follow another one, or the manager starts the
// process again; InfiniteDuration: nobody waits for any (WATCHDOG_USEC, WATCHDOG_PID).
absl::Duration WatchdogTimeout();

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_RUNTIME_SERVICE_MANAGER_H_
