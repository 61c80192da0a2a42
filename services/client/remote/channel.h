// Makes channels to our own services.
#ifndef CORBSLAM_SERVICES_CLIENT_REMOTE_CHANNEL_H_
#define CORBSLAM_SERVICES_CLIENT_REMOTE_CHANNEL_H_

#include <grpcpp/channel.h>
#include <grpcpp/security/credentials.h>

#include <memory>
#include <string>

#include "absl/time/time.h"

namespace corbslam::services {

struct ChannelOptions {
  // A peer that was silent for this long is asked for a sign of life.
  absl::Duration keepalive_time = absl::Seconds(10);
  // The peer is given up, with all calls (UNAVAILABLE), when no sign comes within this time. A
  // robot's question waits behind what its link has not carried yet: at 256 kbit/s that takes many
  // seconds.
  absl::Duration keepalive_timeout = absl::Seconds(20);
  // Limit of an attempt to connect, TLS included. It is short, since an attempt that began during
  // an outage does not learn when the outage ends; the next attempt follows soon.
  absl::Duration connect_timeout = absl::Seconds(8);
};

// Returns a channel to HOST:PORT that notices a dead peer (keepalive) and takes messages up to 4
// MiB. Connecting happens in the background; errors show in the calls. Programs take the
// credentials from services/security.
std::shared_ptr<grpc::Channel> MakeChannel(const std::string& address,
                                           const std::shared_ptr<grpc::ChannelCredentials>&
                                               credentials = grpc::InsecureChannelCredentials(),
                                           const ChannelOptions& options = {});

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_REMOTE_CHANNEL_H_
