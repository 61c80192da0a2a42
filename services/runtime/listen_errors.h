// Explains to people why a port can't be listened on.
#ifndef CORBSLAM_SERVICES_RUNTIME_LISTEN_ERRORS_H_
#define CORBSLAM_SERVICES_RUNTIME_LISTEN_ERRORS_H_

#include <string>

namespace corbslam::services {

// Returns why binding to "HOST:PORT" failed with `error` (errno's), with the process that has the
// port, and with what to do.
std::string ExplainBindError(const std::string& address, int error);

// Returns the same if only the failure is known, as gRPC tells no more: it tries to bind by itself.
std::string ExplainListenFailure(const std::string& address);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_RUNTIME_LISTEN_ERRORS_H_
