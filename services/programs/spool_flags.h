// Adds the flags of a robot's spool: what of its map outlives the process (docs/robot.md).
#ifndef CORBSLAM_SERVICES_PROGRAMS_SPOOL_FLAGS_H_
#define CORBSLAM_SERVICES_PROGRAMS_SPOOL_FLAGS_H_

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client_agent/agent/agent.h"
#include "client_agent/spool/spool.h"

namespace corbslam::services {

struct SpoolFlags {
  std::string folder;  // Empty: there is no spool.
  uint64_t mb = 1024;
  double sync_s = 1;
  bool resume = false;
  double resume_wait_s = 10;
};

void AddSpoolFlags(CLI::App& app, SpoolFlags& flags);
// Returns INVALID_ARGUMENT for flags that need another one, or that do nothing.
absl::Status CheckSpoolFlags(const SpoolFlags& flags, bool has_server);
void ApplySpoolFlags(const SpoolFlags& flags, client_agent::AgentOptions& options);
client_agent::SpoolOptions SpoolOptionsOf(const SpoolFlags& flags, const std::string& owner);
// Returns null if no spool was asked for. `owner` is the agent's whole name.
absl::StatusOr<std::unique_ptr<client_agent::Spool>> OpenSpool(const SpoolFlags& flags,
                                                               const std::string& owner);
// Does so in files that are open.
absl::StatusOr<std::unique_ptr<client_agent::Spool>> OpenSpoolIn(
    std::unique_ptr<client_agent::SpoolFiles> files, const client_agent::SpoolOptions& options);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_SPOOL_FLAGS_H_
