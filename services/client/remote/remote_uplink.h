// An agent's uplink over MapStore.Sync.
#ifndef CORBSLAM_SERVICES_CLIENT_REMOTE_REMOTE_UPLINK_H_
#define CORBSLAM_SERVICES_CLIENT_REMOTE_REMOTE_UPLINK_H_

#include <grpcpp/channel.h>

#include <cstddef>
#include <cstdint>
#include <memory>

#include "slam/exchange/uplink.h"

namespace corbslam {

// Of this process: drawn at random at the first call, never 0.
uint64_t ProcessInstance();

struct RemoteUplinkOptions {
  // What tells the sessions of this process from those of another one with the agent's name; 0: the
  // store makes no difference.
  uint64_t instance = ProcessInstance();
  // The first session takes the place of one that another process holds. Later ones don't: two
  // robots would throw each other out for ever.
  bool take_over = false;
  // Bytes that wait for the network at most; a batch that finds more waiting is refused by Send.
  size_t max_queued_bytes = 8u << 20;
};

// Thread contract and effect are those of Uplink. One Open makes one attempt at a session; trying
// again is the caller's part. A batch longer than a message goes in several. The listener is
// called from threads of gRPC, and may call Send and Open but not Close. Where all that was sent is
// on its way, Close says good-bye and waits for the store's own end of the stream, a second at
// most: the store then knows that nothing broke.
std::unique_ptr<Uplink> MakeRemoteUplink(std::shared_ptr<grpc::Channel> channel,
                                         const RemoteUplinkOptions& options = {});

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_CLIENT_REMOTE_REMOTE_UPLINK_H_
