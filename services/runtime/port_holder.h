// Finds the process that has a port.
#ifndef CORBSLAM_SERVICES_RUNTIME_PORT_HOLDER_H_
#define CORBSLAM_SERVICES_RUNTIME_PORT_HOLDER_H_

#include <sys/socket.h>
#include <sys/types.h>

#include <optional>

namespace corbslam::services {

// Returns the process with a socket that keeps others from `address` (IPv4 or IPv6): one that
// listens there, or else one that has the port for a connection. Returns nullopt if there is none,
// or if it can't be seen from here: a process of another user or of another container.
std::optional<pid_t> FindPortHolder(const sockaddr_storage& address);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_RUNTIME_PORT_HOLDER_H_
