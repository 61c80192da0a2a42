// Adds flags that say what a robot is told of the map that all have made.
#ifndef CORBSLAM_SERVICES_PROGRAMS_SHARE_FLAGS_H_
#define CORBSLAM_SERVICES_PROGRAMS_SHARE_FLAGS_H_

#include <CLI/CLI.hpp>
#include <optional>

#include "absl/status/status.h"
#include "slam/exchange/uplink.h"

namespace corbslam::services {

struct ShareFlags {
  // Nullopt: --share was not given, and the mode is `otherwise`.
  std::optional<ShareMode> mode;
  ShareMode otherwise = ShareMode::kEverything;
  double radius_m = ShareScope().radius_m;
  // The radius was given.
  bool has_radius = false;
};

// Adds --share and --share-radius, which --help-all shows; what is no mode or out of the limits is
// refused with the flag, the value and what it may be.
void AddShareFlags(CLI::App& app, ShareFlags& flags);
// Returns INVALID_ARGUMENT for a radius without --share nearby, and if a flag is set for a robot
// without a map store.
absl::Status CheckShareFlags(const ShareFlags& flags, bool has_server);
ShareScope ScopeOf(const ShareFlags& flags);
// Returns the flags of a robot whose memory is bounded: without --share it is told of what is
// nearby.
ShareFlags WithBoundedMemory(ShareFlags flags);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_SHARE_FLAGS_H_
