// Registers the kind of sources that other programs push: push:SOCKET_PATH.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_PUSH_PUSH_SOURCE_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_PUSH_PUSH_SOURCE_H_

namespace corbslam::client_agent {

// Registers "push:SOCKET_PATH" (docs/push.md) with this program.
void RegisterPushSource();

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_PUSH_PUSH_SOURCE_H_
