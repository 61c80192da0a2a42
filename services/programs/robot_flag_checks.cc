#include "services/programs/robot_flag_checks.h"

#include <set>
#include <string>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "client_agent/live/live_sources.h"
#include "client_agent/source/source_kinds.h"
#include "services/client/remote/channel.h"
#include "services/convert/errors.h"
#include "services/convert/resource_names.h"
#include "services/programs/checks.h"
#include "services/programs/memory_needs.h"
#include "services/programs/observe_flags.h"
#include "services/programs/record_flags.h"
#include "services/server/server.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::ApplyOptions;
using client_agent::FeatureSelection;
using client_agent::ParseFeatureSelection;
using client_agent::ParseSourceSpec;
using client_agent::SourceSpec;
using client_agent::UseRig;

namespace {

absl::StatusOr<SourceSpec> FlaggedSource(const RobotFlags& flags) {
  ASSIGN_OR_RETURN(SourceSpec spec, ParseSourceSpec(flags.source));
  if (!flags.rig.empty()) RETURN_IF_ERROR(UseRig(flags.rig, spec));
  if (!flags.frames.empty()) RETURN_IF_ERROR(ApplyOptions("frames=" + flags.frames, spec));
  return spec;
}

absl::Status CheckFlaggedSource(const RobotFlags& flags) {
  ASSIGN_OR_RETURN(const SourceSpec spec, FlaggedSource(flags));
  return CheckRobotSource(spec, flags.strict);
}

absl::Status CheckPace(const RobotFlags& flags) {
  if (flags.pace != Pace::kStep || flags.server.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "--pace step is of a robot alone: with --server what comes depends on the network; "
      "corbslam run --pace step plays several robots and a store in lockstep");
}

absl::Status NeedsServer(absl::string_view flag) {
  return absl::InvalidArgumentError(absl::StrCat(flag, " needs --server"));
}

absl::StatusOr<int> ParsePictureWidth(absl::string_view text) {
  constexpr int kLeast = 64;
  constexpr int kMost = 1280;
  int width_px = 0;
  if (absl::SimpleAtoi(text, &width_px) &&
      (width_px == 0 || (width_px >= kLeast && width_px <= kMost))) {
    return width_px;
  }
  return absl::InvalidArgumentError(absl::StrCat("--upload: picture=", text,
                                                 ": must be 0 (none) or a width in pixels from ",
                                                 kLeast, " to ", kMost));
}

absl::Status CheckLocaliseOnly(const RobotFlags& flags) {
  if (!flags.localise_only) return absl::OkStatus();
  if (flags.server.empty()) {
    return absl::InvalidArgumentError("--localise-only needs --server, whose map it localises in");
  }
  const ShareMode mode = flags.share.value_or(ShareMode::kEverything);
  if (mode == ShareMode::kNone || mode == ShareMode::kCorrections) {
    return absl::InvalidArgumentError(
        "--localise-only needs others' keyframes: --share nearby or everything");
  }
  if (!flags.spool.folder.empty()) {
    return absl::InvalidArgumentError(
        "--spool (--spool-dir) keeps what a robot maps, and with --localise-only it maps nothing");
  }
  return absl::OkStatus();
}

std::vector<absl::Status> CheckEachSettable(const RobotFlags& flags) {
  const bool has_server = !flags.server.empty();
  return {CheckMemoryBudget(flags.memory_budget_bytes, flags.share, MemoryNeedsOf(flags),
                            has_server || !flags.spool.folder.empty()),
          CheckShare(flags, IsBounded(flags), has_server), CheckLocaliseOnly(flags),
          ParseUpload(flags).status()};
}

}  // namespace

absl::StatusOr<RobotSource> OpenFlaggedSource(const RobotFlags& flags,
                                              const absl::Notification& stop) {
  ASSIGN_OR_RETURN(const SourceSpec spec, FlaggedSource(flags));
  return OpenRobotSource(spec, flags.strict, stop);
}

absl::StatusOr<UploadChoice> ParseUpload(const RobotFlags& flags) {
  UploadChoice choice;
  std::set<absl::string_view> named;
  for (absl::string_view part : absl::StrSplit(flags.upload, '&')) {
    const absl::string_view name = part.substr(0, part.find('='));
    if (!named.insert(name).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("--upload is ", flags.upload, ", which says ", name, " twice"));
    }
    if (absl::ConsumePrefix(&part, "features=")) {
      const absl::StatusOr<FeatureSelection> features = ParseFeatureSelection(part);
      if (!features.ok()) return Locate(features.status(), "--upload");
      choice.features = *features;
    } else if (absl::ConsumePrefix(&part, "picture=")) {
      ASSIGN_OR_RETURN(choice.picture_width_px, ParsePictureWidth(part));
    } else {
      return absl::InvalidArgumentError(absl::StrCat(
          "--upload is ", flags.upload,
          ", must be features=all, features=mapped or features=N, picture=N, or both with & "
          "between them"));
    }
  }
  return choice;
}

SecurityOptions Bearing(SecurityOptions security, Files files) {
  security.files_may_come = files == Files::kMayCome;
  return security;
}

absl::StatusOr<std::shared_ptr<StoreRoute>> MakeStoreRoute(const RobotFlags& flags, Files files) {
  if (flags.server.empty()) return nullptr;
  ASSIGN_OR_RETURN(const auto credentials, MakeChannelCredentials(Bearing(flags.security, files)));
  return std::make_shared<StoreRoute>(MakeChannel(flags.server, credentials),
                                      ConnectWith(credentials));
}

absl::Status CheckListenSecurity(const RobotFlags& flags, Files files) {
  if (flags.listen.empty()) return absl::OkStatus();
  return CheckServerSecurity(Bearing(ListenSecurityOf(flags), files), flags.mission, flags.agent);
}

absl::Status CheckSettable(const RobotFlags& flags) {
  for (const absl::Status& status : CheckEachSettable(flags)) RETURN_IF_ERROR(status);
  return absl::OkStatus();
}

std::vector<absl::Status> CheckPlaces(const RobotFlags& flags) {
  std::vector<absl::Status> found;
  if (!flags.server.empty()) found.push_back(CheckFlagServer("--server", flags.server));
  if (!flags.listen.empty()) found.push_back(CheckFlagAddress("--listen", flags.listen));
  if (!flags.spool.folder.empty()) found.push_back(CheckFolder("--spool", flags.spool.folder));
  found.push_back(CheckSpoolFlags(flags.spool, !flags.server.empty()));
  const bool has_server = !flags.server.empty();
  if (!has_server && flags.uplink_kbps > 0) found.push_back(NeedsServer("--uplink-kbps"));
  if (!has_server && flags.downlink_kbps > 0) found.push_back(NeedsServer("--downlink-kbps"));
  const std::vector<absl::Status> settable = CheckEachSettable(flags);
  found.insert(found.end(), settable.begin(), settable.end());
  found.push_back(CheckSettingsFlags(flags.settings, has_server));
  found.push_back(CheckPace(flags));
  found.push_back(CheckRecording(flags.record));
  for (const std::string& file :
       {flags.stats, flags.trajectory, flags.held_map, flags.told, flags.settings.kept}) {
    if (!file.empty()) found.push_back(CheckFolderOf(file));
  }
  const std::vector<absl::Status> observing = CheckObserving(flags.observe);
  found.insert(found.end(), observing.begin(), observing.end());
  return found;
}

std::vector<absl::Status> CheckRobotFlags(const RobotFlags& flags) {
  std::vector<absl::Status> found = {
      CheckNameSegment("--mission", flags.mission),
      CheckNameSegment("--agent", flags.agent),
      MakeStoreRoute(flags, Files::kMustBeGood).status(),
      CheckListenSecurity(flags, Files::kMustBeGood),
      CheckVocabulary(flags.vocabulary),
      CheckSettingsFiles(flags.settings),
      CheckFlaggedSource(flags),
  };
  const std::vector<absl::Status> places = CheckPlaces(flags);
  found.insert(found.end(), places.begin(), places.end());
  return found;
}

}  // namespace corbslam::services
