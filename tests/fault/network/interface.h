// Handles network devices of the namespace that the calling thread is in.
#ifndef CORBSLAM_TESTS_FAULT_NETWORK_INTERFACE_H_
#define CORBSLAM_TESTS_FAULT_NETWORK_INTERFACE_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace corbslam::tests {

// Switches a device on. UNAVAILABLE names the device and the system's word.
absl::Status BringUp(const std::string& name);

// Opens a device whose packets this process reads and writes, from `address` to `peer` (IPv4),
// switched on. Returns its file, which is not inherited by other programs; closing it removes the
// device.
absl::StatusOr<int> OpenTunnel(const std::string& name, const std::string& address,
                               const std::string& peer);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_FAULT_NETWORK_INTERFACE_H_
