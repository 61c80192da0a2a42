// Makes a fusion worker whose requests are counted and timed: in a store as it sees its workers, in
// a worker as it works.
#ifndef CORBSLAM_SERVICES_OBSERVE_METRICS_MEASURED_FUSION_WORKER_H_
#define CORBSLAM_SERVICES_OBSERVE_METRICS_MEASURED_FUSION_WORKER_H_

#include <prometheus/registry.h>

#include <memory>

#include "slam/exchange/fusion_worker.h"

namespace corbslam::services {

// Keeps the metrics corbslam_fusion_request...: by kind (verify, fuse, adjust) and by how the
// request ended. Thread contract and effect are those of `worker`. Neither it nor `registry` is
// owned; both must outlive the result.
std::unique_ptr<FusionWorker> MakeMeasuredFusionWorker(FusionWorker* worker,
                                                       prometheus::Registry& registry);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_METRICS_MEASURED_FUSION_WORKER_H_
