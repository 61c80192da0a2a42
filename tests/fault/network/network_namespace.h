// Makes network namespaces: a network of its own for a robot, on the test's machine.
#ifndef CORBSLAM_TESTS_FAULT_NETWORK_NETWORK_NAMESPACE_H_
#define CORBSLAM_TESTS_FAULT_NETWORK_NETWORK_NAMESPACE_H_

#include <functional>
#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace corbslam::tests {

// A namespace has no name and leaves nothing behind: it goes with this object and the processes in
// it. All calls must come from one thread.
class NetworkNamespace {
 public:
  // Creates a namespace whose loopback device is up. PERMISSION_DENIED where this process may not
  // (it needs to be root); UNAVAILABLE with the system's word otherwise.
  static absl::StatusOr<std::unique_ptr<NetworkNamespace>> Create();
  // Creates one in the same way, in which this thread stays, with all threads and processes that it
  // starts.
  static absl::Status Enter();
  ~NetworkNamespace();
  NetworkNamespace(const NetworkNamespace&) = delete;
  NetworkNamespace& operator=(const NetworkNamespace&) = delete;

  // Calls the function while this thread is in the namespace. Sockets made and processes and
  // threads started meanwhile stay in it.
  absl::Status Run(const std::function<absl::Status()>& function);

 private:
  NetworkNamespace(int own, int outside) : own_(own), outside_(outside) {}

  const int own_;
  const int outside_;  // The namespace in which Create was called.
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_FAULT_NETWORK_NETWORK_NAMESPACE_H_
