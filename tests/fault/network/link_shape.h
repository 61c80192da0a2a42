// Says what a bad radio link does to packets.
#ifndef CORBSLAM_TESTS_FAULT_NETWORK_LINK_SHAPE_H_
#define CORBSLAM_TESTS_FAULT_NETWORK_LINK_SHAPE_H_

#include <cstddef>
#include <cstdint>

#include "absl/status/status.h"
#include "absl/time/time.h"

namespace corbslam::tests {

// The shape is the same in both directions. By default nothing happens to packets.
struct LinkShape {
  // Delay from one end to the other, beside the time that the rate takes.
  absl::Duration delay;
  // Share of packets that get lost, in [0, 1), each by itself.
  double loss = 0;
  // Bits a second; 0: as fast as can be.
  double rate = 0;
  // At most so many bytes wait for the rate; what comes beyond is lost, as in a modem.
  size_t max_waiting_bytes = 256 << 10;
  // The link is dead for `outage` from `outage_begin` on, counted from its start.
  absl::Duration outage_begin;
  absl::Duration outage;
  // If both are positive the link works for `up`, then it doesn't for `down`, again and again.
  absl::Duration up;
  absl::Duration down;
  uint64_t seed = 1;  // Seed of the losses.

  // INVALID_ARGUMENT names the field.
  absl::Status Validate() const;
  // Returns whether packets pass so long after the link's start.
  bool IsUp(absl::Duration since_start) const;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_FAULT_NETWORK_LINK_SHAPE_H_
