// Holds the packets that are on their way through one direction of a link.
#ifndef CORBSLAM_TESTS_FAULT_NETWORK_LINK_QUEUE_H_
#define CORBSLAM_TESTS_FAULT_NETWORK_LINK_QUEUE_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <random>
#include <string>

#include "absl/time/time.h"
#include "tests/fault/network/link_shape.h"

namespace corbslam::tests {

struct LinkCounts {
  uint64_t passed = 0;
  uint64_t lost = 0;  // Packets lost by chance, for want of room, or during an outage.
};

// The queue knows no clock: the same packets at the same times meet the same fate. Not thread-safe.
class LinkQueue {
 public:
  // `shape` must be valid. `salt` makes the losses of several queues differ.
  LinkQueue(const LinkShape& shape, uint64_t salt, absl::Time start)
      : shape_(shape), start_(start), random_(shape.seed ^ salt), free_(start) {}

  // Takes a packet that comes in. Times never fall.
  void Push(std::string packet, absl::Time now);
  // Returns the next packet that is through by now; none before NextDue.
  std::optional<std::string> Pop(absl::Time now);
  // Returns the infinite future when nothing is on its way.
  absl::Time NextDue() const;

  const LinkCounts& counts() const { return counts_; }

 private:
  struct Packet {
    absl::Time due;
    std::string bytes;
  };

  bool IsLost(absl::Time now, size_t bytes);

  const LinkShape shape_;
  const absl::Time start_;
  std::mt19937_64 random_;
  // Time at which the last packet has left at the link's rate.
  absl::Time free_;
  std::deque<Packet> packets_;
  LinkCounts counts_;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_FAULT_NETWORK_LINK_QUEUE_H_
