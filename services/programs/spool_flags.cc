#include "services/programs/spool_flags.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "services/command_line/setting.h"
#include "services/convert/batch_bytes.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::AgentOptions;
using client_agent::OpenSpoolFolder;
using client_agent::Spool;
using client_agent::SpoolFiles;
using client_agent::SpoolOptions;
using client_agent::SyncPolicy;

void AddSpoolFlags(CLI::App& app, SpoolFlags& flags) {
  AddSettings(
      app,
      {
          {"--spool,--spool-dir",
           &flags.folder,
           "Folder in which what is mapped outlives the program and power loss",
           {.unit = "DIR"}},
          {"--spool-mb", &flags.mb, "MiB in it at most", RareWithin(1, 1 << 20)},
          {"--spool-sync-s", &flags.sync_s,
           "Seconds after which a loss of power takes nothing; 0: only what memory has no room for "
           "goes there, and what is left at the end",
           RareWithin(0, 3600)},
          {"--resume", &flags.resume, "Go on with the local map that --spool keeps"},
          {"--resume-wait-s", &flags.resume_wait_s,
           "Seconds in which a place in it must be recognised, else a new one begins",
           RareWithin(0, 86400)},
      });
}

absl::Status CheckSpoolFlags(const SpoolFlags& flags, bool has_server) {
  if (flags.resume && flags.folder.empty()) {
    return absl::InvalidArgumentError("--resume needs --spool, which keeps the local map");
  }
  if (flags.resume && flags.sync_s == 0) {
    return absl::InvalidArgumentError(
        "--resume needs all of the local map in the spool, and --spool-sync-s is 0, with which "
        "only some of it goes there");
  }
  if (!flags.folder.empty() && !has_server && flags.sync_s == 0) {
    return absl::InvalidArgumentError(
        "--spool without --server keeps what is mapped for a later run, and --spool-sync-s is 0, "
        "with which it keeps what a server has not taken");
  }
  return absl::OkStatus();
}

void ApplySpoolFlags(const SpoolFlags& flags, AgentOptions& options) {
  if (flags.folder.empty()) return;
  options.spool_within = absl::Seconds(flags.sync_s);
  options.resume = flags.resume;
  options.resume_wait = absl::Seconds(flags.resume_wait_s);
}

SpoolOptions SpoolOptionsOf(const SpoolFlags& flags, const std::string& owner) {
  SpoolOptions options;
  options.owner = owner;
  options.max_bytes = flags.mb << 20;
  // A quarter goes until it is written, the rest is what the disk itself takes.
  if (flags.sync_s > 0) options.sync = SyncPolicy{.after = absl::Seconds(flags.sync_s / 2)};
  return options;
}

absl::StatusOr<std::unique_ptr<Spool>> OpenSpool(const SpoolFlags& flags,
                                                 const std::string& owner) {
  if (flags.folder.empty()) return nullptr;
  ASSIGN_OR_RETURN(std::unique_ptr<SpoolFiles> files, OpenSpoolFolder(flags.folder));
  return OpenSpoolIn(std::move(files), SpoolOptionsOf(flags, owner));
}

absl::StatusOr<std::unique_ptr<Spool>> OpenSpoolIn(std::unique_ptr<SpoolFiles> files,
                                                   const SpoolOptions& options) {
  return Spool::Open(options, std::move(files), {&EncodeBatch, &DecodeBatch});
}

}  // namespace corbslam::services
