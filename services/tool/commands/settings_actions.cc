// Adds `mission create` and `mission set`.
#include <cstdint>

#include "absl/strings/str_cat.h"
#include "services/command_line/values.h"
#include "services/convert/resource_names.h"
#include "services/tool/commands/mission_arguments.h"
#include "services/tool/mission/mission_admin.h"
#include "services/tool/mission/mission_json.h"
#include "services/tool/mission/mission_settings.h"
#include "services/tool/output/result.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// No mission and no link has more.
constexpr uint64_t kMost = uint64_t{1} << 50;
constexpr uint64_t kMost_mib = kMost >> 20;

void Print(const char* what, const v1::Mission& mission) {
  PrintResult(
      absl::StrCat(what, " mission ", LastSegment(mission.name()), "\n", FormatSettings(mission)),
      ToJson(mission));
}

absl::Status Create(const MissionArguments& arguments) {
  RETURN_IF_ERROR(CheckNameSegment("NAME", arguments.mission));
  v1::Mission wanted;
  wanted.set_name(MissionName(arguments.mission));
  if (!IsEmpty(arguments.settings)) {
    ASSIGN_OR_RETURN(const v1::UpdateMissionRequest filled, MakeUpdate(arguments.settings, wanted));
    wanted = filled.mission();
  }
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  ASSIGN_OR_RETURN(const v1::Mission made, MissionAdmin(channel).Create(wanted));
  Print("created", made);
  return absl::OkStatus();
}

absl::Status Set(const MissionArguments& arguments) {
  RETURN_IF_ERROR(CheckNameSegment("NAME", arguments.mission));
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  MissionAdmin admin(channel);
  const auto change = [&](const v1::Mission& now) { return MakeUpdate(arguments.settings, now); };
  ASSIGN_OR_RETURN(const v1::Mission changed, admin.Change(arguments.mission, change));
  Print("changed", changed);
  return absl::OkStatus();
}

void AddSettingFlags(CLI::App& action, MissionSettings& settings) {
  // An empty one takes back what was there, which an optional value would not tell from none.
  MayBeEmpty(action.add_option_function<std::string>(
      "--description", [&settings](const std::string& text) { settings.description = text; },
      "What people want to know of it"));
  action.add_option("--label", settings.labels, "KEY=VALUE, for tools; may be repeated")
      ->allow_extra_args(false);
  action.add_option("--max-keyframes", settings.max_keyframes, "Keyframes at most; 0: no limit")
      ->check(CLI::Range(uint64_t{0}, kMost));
  action
      .add_option("--max-memory-mb", settings.max_memory_mb,
                  "MiB of the store's memory at most; 0: no limit")
      ->check(CLI::Range(uint64_t{0}, kMost_mib));
  action.add_option("--max-disk-mb", settings.max_disk_mb, "MiB of disk at most; 0: no limit")
      ->check(CLI::Range(uint64_t{0}, kMost_mib));
  action
      .add_option("--uplink-kbps", settings.uplink_kbps,
                  "Kilobits a second that each robot sends at most; 0: no limit")
      ->check(CLI::Range(uint64_t{0}, kMost));
  action.add_option("--retention", settings.retention,
                    "Deleted once unused for so long, as 30d or 12h; never");
  action.add_option("--origin", settings.origin,
                    "LATITUDE,LONGITUDE[,ALTITUDE[,HEADING]] of the global frame's origin; degrees "
                    "and metres, HEADING of its x axis clockwise from north");
}

}  // namespace

void AddSettingActions(CLI::App& mission, const std::shared_ptr<MissionArguments>& arguments,
                       Command& chosen) {
  CLI::App* create = AddMissionAction(mission, "create", "Make a mission before any robot comes",
                                      &Create, arguments, chosen);
  CLI::App* set = AddMissionAction(mission, "set", "Change what is set of a mission, at once", &Set,
                                   arguments, chosen);
  for (CLI::App* action : {create, set}) {
    action->add_option("NAME,--mission", arguments->mission, "Its name")->required();
    AddSettingFlags(*action, arguments->settings);
    AddJsonFlag(*action, *arguments);
  }
  set->add_option("--remove-label", arguments->settings.remove_labels,
                  "KEY of a label that goes; may be repeated")
      ->allow_extra_args(false);
  set->add_option("--agent", arguments->settings.agent,
                  "The limits are those of this robot, not of the mission");
}

}  // namespace corbslam::services
