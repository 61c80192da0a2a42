// A pool of fusion workers elsewhere.
#ifndef CORBSLAM_SERVICES_REMOTE_REMOTE_FUSION_WORKER_H_
#define CORBSLAM_SERVICES_REMOTE_REMOTE_FUSION_WORKER_H_

#include <grpcpp/channel.h>

#include <memory>
#include <vector>

#include "absl/time/time.h"
#include "slam/exchange/fusion_worker.h"

namespace corbslam {

struct RemoteFusionWorkerOptions {
  // After this a request is given up (DEADLINE_EXCEEDED).
  absl::Duration deadline = absl::Minutes(10);
};

// Thread contract and errors are those of FusionWorker. A request goes to the channel with the
// fewest requests under way; when that one is UNAVAILABLE, it goes to each of the others once. While
// it is sent and waits for its turn, progress is asked about ten times a second with what it was
// last told.
// Keyframes are sent without what the work does not look at: descriptors for AdjustBundle,
// keypoints without a point for AdjustBundle and for the candidates of VerifyOverlap.
std::unique_ptr<FusionWorker> MakeRemoteFusionWorker(
    std::vector<std::shared_ptr<grpc::Channel>> workers,
    const RemoteFusionWorkerOptions& options = {});

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_REMOTE_REMOTE_FUSION_WORKER_H_
