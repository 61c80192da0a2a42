// Serves a fusion worker by its contract: FusionWorker of
// proto/corbslam/v1/fusion_worker_service.proto.
#ifndef CORBSLAM_SERVICES_FUSION_WORKER_SERVICE_FUSION_WORKER_SERVICE_H_
#define CORBSLAM_SERVICES_FUSION_WORKER_SERVICE_FUSION_WORKER_SERVICE_H_

#include <atomic>
#include <cstddef>
#include <functional>

#include "corbslam/v1/fusion_worker_service.grpc.pb.h"
#include "services/fusion_worker_service/work_queue.h"
#include "services/server/task_pool.h"
#include "slam/exchange/fusion_worker.h"

namespace corbslam::services {

struct FusionWorkerServiceOptions {
  // Number of requests that are worked on at once; the rest wait for their missions' turns.
  int threads = 2;
  // Most requests that are received, worked on or wait; further ones get UNAVAILABLE, so that the
  // caller asks another worker.
  int max_requests = 16;
  // Called, on any thread, when a request has ended and what it took is freed; null: nobody cares.
  std::function<void()> when_done = nullptr;
};

// Receives requests and lets the worker do them. `worker` is not owned and must outlive it; the
// server must be shut down before it is destroyed. Thread-safe.
class FusionWorkerService : public v1::FusionWorker::CallbackService {
 public:
  explicit FusionWorkerService(FusionWorker* worker, const FusionWorkerServiceOptions& options = {})
      : worker_(*worker), options_(options), pool_(options.threads) {}

  grpc::ServerBidiReactor<v1::VerifyOverlapRequest, v1::VerifyOverlapResponse>* VerifyOverlap(
      grpc::CallbackServerContext* context) override;
  grpc::ServerBidiReactor<v1::FuseMapsRequest, v1::FuseMapsResponse>* FuseMaps(
      grpc::CallbackServerContext* context) override;
  grpc::ServerBidiReactor<v1::AdjustBundleRequest, v1::AdjustBundleResponse>* AdjustBundle(
      grpc::CallbackServerContext* context) override;
  grpc::ServerBidiReactor<v1::LocateFrameRequest, v1::LocateFrameResponse>* LocateFrame(
      grpc::CallbackServerContext* context) override;
  grpc::ServerUnaryReactor* ExtractFeatures(grpc::CallbackServerContext* context,
                                            const v1::ExtractFeaturesRequest* request,
                                            v1::ExtractFeaturesResponse* response) override;

  // Returns the number of requests that are received, worked on or waiting; waiting_requests counts
  // those of them that no thread has begun with.
  int requests() const { return requests_; }
  size_t waiting_requests() const { return pool_.waiting(); }

 private:
  FusionWorker& worker_;
  const FusionWorkerServiceOptions options_;
  std::atomic<int> requests_{0};
  WorkQueue queue_;
  TaskPool pool_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_FUSION_WORKER_SERVICE_FUSION_WORKER_SERVICE_H_
