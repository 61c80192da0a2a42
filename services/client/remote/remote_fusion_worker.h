// Shares work among fusion workers in other processes.
#ifndef CORBSLAM_SERVICES_CLIENT_REMOTE_REMOTE_FUSION_WORKER_H_
#define CORBSLAM_SERVICES_CLIENT_REMOTE_REMOTE_FUSION_WORKER_H_

#include <grpcpp/channel.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "slam/exchange/fusion_worker.h"

namespace corbslam::services {

struct RemoteFusionWorkerOptions {
  // A request that takes longer is given up (DEADLINE_EXCEEDED).
  absl::Duration deadline = absl::Minutes(10);
  // Returns for people what is the matter with a worker, by its index, whose call ended as `seen`.
  // It may block. Null: `seen` says it.
  std::function<absl::Status(size_t worker, const absl::Status& seen)> explain = nullptr;
};

// A worker in another process.
struct RemoteWorker {
  std::string address;  // For telling workers apart; empty: this one is like no other.
  std::shared_ptr<grpc::Channel> channel;
  // Returns for people what is the matter with it, a call of which ended so; null: the status says
  // it.
  std::function<absl::Status(const absl::Status& seen)> explain = nullptr;
};

// Workers as one, whose thread contract and errors are those of FusionWorker. A request goes to the
// one with the fewest requests under way (worker_choice.h); when that one is UNAVAILABLE, is no
// fusion worker (UNIMPLEMENTED) or does not admit this caller (UNAUTHENTICATED, PERMISSION_DENIED),
// it goes to each of the others once. If none takes it, the result is UNAVAILABLE: another address
// or certificate can mend it. While a request is sent and waits for its turn, progress is asked
// about ten times a second with what it was last told.
// Keyframes are sent without what the work does not look at: descriptors for AdjustBundle,
// keypoints without a point for AdjustBundle and for the candidates of VerifyOverlap.
class RemoteFusionWorkers : public FusionWorker {
 public:
  // From here on requests go to these. What is under way ends where it is; of those that are known
  // by their addresses, what is under way still counts.
  virtual void Use(std::vector<RemoteWorker> workers) = 0;
};

std::unique_ptr<RemoteFusionWorkers> MakeRemoteFusionWorkers(
    std::vector<RemoteWorker> workers, absl::Duration deadline = absl::Minutes(10));
std::unique_ptr<FusionWorker> MakeRemoteFusionWorker(
    std::vector<std::shared_ptr<grpc::Channel>> workers,
    const RemoteFusionWorkerOptions& options = {});

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_REMOTE_REMOTE_FUSION_WORKER_H_
