// A fusion worker that keeps what it is asked.
#ifndef CORBSLAM_SERVICES_OBSERVE_KEPT_WORK_KEEPING_FUSION_WORKER_H_
#define CORBSLAM_SERVICES_OBSERVE_KEPT_WORK_KEEPING_FUSION_WORKER_H_

#include <memory>
#include <string>

#include "slam/exchange/fusion_worker.h"

namespace corbslam {

// Writes each request to adjust to a file of its own in `folder` before it is worked on:
// TIME_NUMBER.adjustment, which sort by when they came. Nothing is ever deleted. What can't be
// written is logged, and worked on all the same. Thread contract and results are those of `worker`,
// which must outlive it.
std::unique_ptr<FusionWorker> MakeKeepingFusionWorker(FusionWorker* worker, std::string folder);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_OBSERVE_KEPT_WORK_KEEPING_FUSION_WORKER_H_
