// Connects an agent to a map store over MapStore.Sync.
#ifndef CORBSLAM_SERVICES_CLIENT_REMOTE_REMOTE_UPLINK_H_
#define CORBSLAM_SERVICES_CLIENT_REMOTE_REMOTE_UPLINK_H_

#include <grpcpp/channel.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

#include "corbslam/v1/robot_settings.pb.h"
#include "services/client/remote/store_route.h"
#include "slam/exchange/uplink.h"

namespace corbslam::services {

// Returns the number of this process, which is drawn at random at the first call and never 0.
uint64_t ProcessInstance();

struct RemoteUplinkOptions {
  // Tells the sessions of this process from those of another one with the agent's name; 0: the
  // store makes no difference.
  uint64_t instance = ProcessInstance();
  // True: the first session takes the place of one that another process holds. Later ones don't:
  // two robots would throw each other out for ever.
  bool take_over = false;
  // Most bytes that may wait for the network; a batch that finds more waiting is refused by Send.
  size_t max_queued_bytes = 8u << 20;
  // Told of all settings that the store has for this robot: after a session has begun, if there are
  // any, and when they change. Nobody has checked who signed them. Called as the listener is, and
  // after Close not any more; null: the store is not asked for any.
  std::function<void(const v1::RobotSettingsList&)> on_settings = nullptr;
};

// Makes an uplink whose thread contract and effect are those of Uplink. One Open makes one attempt
// at a session; the caller tries again. A batch longer than a message goes in several. The listener
// is called from threads of gRPC, and may call Send and Open but not Close. If all that was sent is
// on its way, Close says good-bye and waits for the store's own end of the stream, for a second at
// most: the store then knows that nothing broke.
// A store that says that another one has the mission is followed there, as `route` does; a session
// that had begun ends first.
std::unique_ptr<Uplink> MakeRemoteUplink(std::shared_ptr<StoreRoute> route,
                                         const RemoteUplinkOptions& options = {});
// The same, with a store that nobody is sent on from.
std::unique_ptr<Uplink> MakeRemoteUplink(std::shared_ptr<grpc::Channel> channel,
                                         const RemoteUplinkOptions& options = {});

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_REMOTE_REMOTE_UPLINK_H_
