// Makes a bad radio link between two network namespaces.
#ifndef CORBSLAM_TESTS_FAULT_NETWORK_SHAPED_LINK_H_
#define CORBSLAM_TESTS_FAULT_NETWORK_SHAPED_LINK_H_

#include <memory>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "tests/fault/network/link_queue.h"
#include "tests/fault/network/link_shape.h"
#include "tests/fault/network/network_namespace.h"

namespace corbslam::tests {

// A link has a device in each namespace, and a thread that carries packets between the two as the
// shape says: what `tc netem` does in the kernel, where the kernel has it. An outage swallows
// packets, and nobody is told. The link goes with the object.
class ShapedLink {
 public:
  struct Ends {
    NetworkNamespace* here = nullptr;  // Null: the calling thread's namespace.
    NetworkNamespace* there = nullptr;
    // IPv4 addresses that nothing else in the two namespaces uses.
    std::string address_here;
    std::string address_there;
  };

  // The link's time starts now. Errors are those of NetworkNamespace and OpenTunnel;
  // INVALID_ARGUMENT for an impossible shape.
  static absl::StatusOr<std::unique_ptr<ShapedLink>> Create(const Ends& ends,
                                                            const LinkShape& shape);
  ~ShapedLink();
  ShapedLink(const ShapedLink&) = delete;
  ShapedLink& operator=(const ShapedLink&) = delete;

  // Returns the counts of both directions together.
  LinkCounts counts() const;

 private:
  ShapedLink(int here, int there, int stop, const LinkShape& shape);
  void Carry(const LinkShape& shape);

  const int here_;
  const int there_;
  const int stop_;  // An eventfd that ends the thread.
  mutable absl::Mutex mutex_;
  LinkCounts counts_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_FAULT_NETWORK_SHAPED_LINK_H_
