// Makes a fusion worker that saves what it is asked.
#ifndef CORBSLAM_SERVICES_OBSERVE_ADJUSTMENT_FILES_SAVING_FUSION_WORKER_H_
#define CORBSLAM_SERVICES_OBSERVE_ADJUSTMENT_FILES_SAVING_FUSION_WORKER_H_

#include <memory>
#include <string>

#include "slam/exchange/fusion_worker.h"

namespace corbslam::services {

// Writes each request to adjust to a file of its own in `folder` before `worker` works on it. The
// files are called TIME_NUMBER.adjustment, so that they sort by when the requests came, and are
// never deleted. A failure to write is logged, and the request is worked on all the same. Thread
// contract and results are those of `worker`, which must outlive the result.
std::unique_ptr<FusionWorker> MakeSavingFusionWorker(FusionWorker* worker, std::string folder);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_ADJUSTMENT_FILES_SAVING_FUSION_WORKER_H_
