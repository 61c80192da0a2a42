// Reads the streams in which a map store tells a mission's map.
#ifndef CORBSLAM_SERVICES_CLIENT_STORE_MAP_STREAMS_H_
#define CORBSLAM_SERVICES_CLIENT_STORE_MAP_STREAMS_H_

#include <functional>
#include <string>

#include "absl/status/status.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"

namespace corbslam::services {

// Takes the next message; an error ends the stream, and is what the reader returns.
using TakeMapMessage = std::function<absl::Status(const v1::WatchMapResponse& message)>;

// Gives the messages of the map as it is, with its points or without, up to the one after which it
// is whole. DATA_LOSS if the stream ends before; else what the store says.
absl::Status ReadWholeMap(v1::MapStore::Stub& stub, const std::string& mission, bool with_points,
                          const TakeMapMessage& take);

// Gives all messages of a replay. DATA_LOSS if it ends within a moment; else what the store says.
absl::Status ReadReplay(v1::MapStore::Stub& stub, const v1::ReplayMapRequest& request,
                        const TakeMapMessage& take);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_STORE_MAP_STREAMS_H_
