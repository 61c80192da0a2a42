// Channels to our own services.
#ifndef CORBSLAM_SERVICES_REMOTE_CHANNEL_H_
#define CORBSLAM_SERVICES_REMOTE_CHANNEL_H_

#include <grpcpp/channel.h>
#include <grpcpp/security/credentials.h>

#include <memory>
#include <string>

namespace corbslam {

// A channel to HOST:PORT that notices a dead peer (keepalive) and takes messages up to 4 MiB.
// Connecting happens in the background; errors show in the calls. Programs take the credentials
// from services/security.
std::shared_ptr<grpc::Channel> MakeChannel(const std::string& address,
                                           const std::shared_ptr<grpc::ChannelCredentials>&
                                               credentials = grpc::InsecureChannelCredentials());

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_REMOTE_CHANNEL_H_
