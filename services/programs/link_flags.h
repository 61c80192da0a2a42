// Adds flags that bound what a robot's link may carry (docs/adr/0019-link-budgets.md).
#ifndef CORBSLAM_SERVICES_PROGRAMS_LINK_FLAGS_H_
#define CORBSLAM_SERVICES_PROGRAMS_LINK_FLAGS_H_

#include <CLI/CLI.hpp>
#include <cstdint>

#include "absl/status/status.h"

namespace corbslam::services {

// Bounds in thousands of bits a second; 0 means no bound.
struct LinkFlags {
  uint64_t uplink_kbps = 0;
  uint64_t downlink_kbps = 0;
};

constexpr uint64_t kLeastKbps = 8;
constexpr uint64_t kMostKbps = 10'000'000;

constexpr uint64_t BytesPerSecond(uint64_t kbps) { return kbps * 125; }

// Adds --uplink-kbps and --downlink-kbps; a value that is neither 0 nor within the limits is
// refused with the flag, the value and the limits.
void AddLinkFlags(CLI::App& app, LinkFlags& flags);
// Checks the flags of a robot without a map store: INVALID_ARGUMENT if one is set.
absl::Status CheckNoLinkFlags(const LinkFlags& flags);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_LINK_FLAGS_H_
