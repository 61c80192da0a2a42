// Adds flags that say what a robot is told of the map that all have made.
#ifndef CORBSLAM_SERVICES_PROGRAMS_SHARE_FLAGS_H_
#define CORBSLAM_SERVICES_PROGRAMS_SHARE_FLAGS_H_

#include <CLI/CLI.hpp>

#include "absl/status/status.h"
#include "slam/exchange/uplink.h"

namespace corbslam::services {

struct ShareFlags {
  ShareMode mode = ShareMode::kEverything;
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

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_SHARE_FLAGS_H_
