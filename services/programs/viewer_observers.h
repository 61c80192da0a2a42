// Makes what watches a map viewer at work: metrics, if the flags say so.
#ifndef CORBSLAM_SERVICES_PROGRAMS_VIEWER_OBSERVERS_H_
#define CORBSLAM_SERVICES_PROGRAMS_VIEWER_OBSERVERS_H_

#include <memory>

#include "absl/status/statusor.h"
#include "services/http/web_server.h"
#include "services/observe/metrics/metrics_endpoint.h"
#include "services/programs/observe_flags.h"
#include "services/viewer/viewer.h"

namespace corbslam::services {

// Serves the metrics, and announces the address; null if none are wanted. `viewer` and `server` are
// not owned and must outlive the result.
absl::StatusOr<std::unique_ptr<MetricsEndpoint>> ServeViewerMetrics(const ObserveFlags& flags,
                                                                    const Viewer& viewer,
                                                                    const WebServer& server);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_VIEWER_OBSERVERS_H_
