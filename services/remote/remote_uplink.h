// An agent's uplink over MapStore.Sync.
#ifndef CORBSLAM_SERVICES_REMOTE_REMOTE_UPLINK_H_
#define CORBSLAM_SERVICES_REMOTE_REMOTE_UPLINK_H_

#include <grpcpp/channel.h>

#include <cstddef>
#include <memory>

#include "slam/exchange/uplink.h"

namespace corbslam {

struct RemoteUplinkOptions {
  // Bytes that wait for the network at most; a batch that finds more waiting is refused by Send.
  size_t max_queued_bytes = 8u << 20;
};

// Thread contract and effect are those of Uplink. One Open makes one attempt at a session; trying
// again is the caller's part. A batch longer than a message goes in several. The listener is
// called from threads of gRPC, and may call Send and Open but not Close.
std::unique_ptr<Uplink> MakeRemoteUplink(std::shared_ptr<grpc::Channel> channel,
                                         const RemoteUplinkOptions& options = {});

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_REMOTE_REMOTE_UPLINK_H_
