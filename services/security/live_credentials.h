// Makes gRPC's credentials of a certificate, its key and authorities that may be replaced.
#ifndef CORBSLAM_SERVICES_SECURITY_LIVE_CREDENTIALS_H_
#define CORBSLAM_SERVICES_SECURITY_LIVE_CREDENTIALS_H_

#include <grpc/grpc_security_constants.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/security/server_credentials.h>

#include <memory>

#include "services/security/key_material.h"

namespace corbslam::services {

// `kept` lives as long as gRPC uses the credentials: what owns the key material and replaces it. A
// server has a certificate, a client authorities; either may have both.
std::shared_ptr<grpc::ServerCredentials> MakeLiveServerCredentials(
    const KeyMaterial& material, grpc_ssl_client_certificate_request_type request,
    std::shared_ptr<const void> kept);
// The server's certificate must be of the authorities, and for the host that is called.
std::shared_ptr<grpc::ChannelCredentials> MakeLiveChannelCredentials(
    const KeyMaterial& material, std::shared_ptr<const void> kept);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_LIVE_CREDENTIALS_H_
