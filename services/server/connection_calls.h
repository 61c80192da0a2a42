// Tells a connection front which connections have calls under way.
#ifndef CORBSLAM_SERVICES_SERVER_CONNECTION_CALLS_H_
#define CORBSLAM_SERVICES_SERVER_CONNECTION_CALLS_H_

#include <grpcpp/support/server_interceptor.h>

#include <memory>

#include "services/server/connection_front.h"

namespace corbslam::services {

// Returns interceptors for grpc::ServerBuilder::experimental().SetInterceptorCreators. Calls of our
// own services count alone: anybody may have gRPC's health watched for ever. `front` is not owned,
// must outlive the server.
std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> MakeConnectionInterceptors(
    ConnectionFront* front);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_CONNECTION_CALLS_H_
