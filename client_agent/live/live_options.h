// The options that every live camera's source has (docs/live.md).
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_LIVE_OPTIONS_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_LIVE_OPTIONS_H_

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/live/live_stream.h"
#include "client_agent/source/rig/rig.h"

namespace corbslam::client_agent {

struct LiveSourceOptions {
  std::string rig;
  double pair_within_ms = 5;
  std::optional<bool> registers;   // LiveOptions::registers.
  std::optional<bool> restarts;    // Nullopt: as the kind of camera does it.
  bool trust_calibration = false;  // Also an improbable rig is taken.
};

std::vector<absl::string_view> LiveOptionNames();

// INVALID_ARGUMENT names the option, its value and what it wants.
absl::Status SetLiveOption(absl::string_view key, absl::string_view value,
                           LiveSourceOptions& options);
absl::Status BadLiveOption(absl::string_view key, absl::string_view value,
                           absl::string_view wanted);

// Returns name and value of the options that differ from their defaults.
std::vector<std::pair<std::string, std::string>> FormatLiveOptions(
    const LiveSourceOptions& options);

// Reads and judges the rig; what is improbable and trusted is logged. INVALID_ARGUMENT without one:
// `kind` names the source in the message.
absl::StatusOr<Rig> ReadLiveRig(absl::string_view kind, const LiveSourceOptions& options);

LiveOptions StreamOptions(const std::string& name, const LiveSourceOptions& options);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_LIVE_OPTIONS_H_
