// Runs the fusion worker in this process: verification, fusing and bundle adjustment as pure
// functions from request to result.
#ifndef CORBSLAM_FUSION_WORKER_LOCAL_FUSION_WORKER_H_
#define CORBSLAM_FUSION_WORKER_LOCAL_FUSION_WORKER_H_

#include <cstdint>
#include <memory>

#include "slam/exchange/fusion_worker.h"

namespace corbslam::fusion_worker {

struct FusionWorkerOptions {
  // Threads of the solver for FuseMaps; AdjustBundle takes the request's number. With 1, results
  // repeat to the bit.
  int threads = 1;
  // Seed of all random choices: the same request gives the same result.
  uint64_t seed = 1;
};

// Makes a worker, which is stateless between calls and thread-safe. It returns INVALID_ARGUMENT,
// naming the id, for views that contradict themselves or the request, and CANCELLED when the
// progress callback returns false.
std::unique_ptr<FusionWorker> MakeLocalFusionWorker(const FusionWorkerOptions& options = {});

}  // namespace corbslam::fusion_worker

#endif  // CORBSLAM_FUSION_WORKER_LOCAL_FUSION_WORKER_H_
