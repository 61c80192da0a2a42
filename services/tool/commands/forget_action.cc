#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "services/client/store/local_map_names.h"
#include "services/convert/resource_names.h"
#include "services/tool/commands/mission_arguments.h"
#include "services/tool/mission/mission_admin.h"
#include "services/tool/output/confirmation.h"
#include "services/tool/output/result.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// Reads a time by the robot's clock: nanoseconds, or a date where that clock is Unix time.
absl::StatusOr<int64_t> ReadRobotTime(const std::string& text) {
  int64_t time_ns = 0;
  if (absl::SimpleAtoi(text, &time_ns)) return time_ns;
  absl::Time time;
  std::string error;
  if (absl::ParseTime(absl::RFC3339_full, text, &time, &error)) return absl::ToUnixNanos(time);
  return absl::InvalidArgumentError(
      absl::StrCat("--before ", text, ": give nanoseconds of the robot's clock, or a time like ",
                   "2026-11-28T12:00:00Z (", error, ")"));
}

absl::StatusOr<v1::ForgetLocalMapsRequest> MakeRequest(const MissionArguments& arguments) {
  v1::ForgetLocalMapsRequest request;
  request.set_parent(AgentName(arguments.mission, arguments.agent));
  request.set_dry_run(arguments.dry_run);
  if (arguments.before.empty() == !arguments.keep_local_maps.has_value()) {
    return absl::InvalidArgumentError("give either --before or --keep");
  }
  if (arguments.keep_local_maps.has_value()) {
    request.set_keep(*arguments.keep_local_maps);
    return request;
  }
  ASSIGN_OR_RETURN(const int64_t before_ns, ReadRobotTime(arguments.before));
  request.set_before_ns(before_ns);
  return request;
}

absl::Status Forget(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(const v1::ForgetLocalMapsRequest request, MakeRequest(arguments));
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  if (!arguments.dry_run) {
    RETURN_IF_ERROR(
        ConfirmLoss(absl::StrCat("Sessions of ", arguments.agent, " in mission ", arguments.mission,
                                 " go for good; --dry-run says which."),
                    arguments.yes));
  }
  MissionAdmin admin(channel);
  ASSIGN_OR_RETURN(const v1::ForgetLocalMapsResponse forgotten, admin.Forget(request));
  nlohmann::ordered_json ids = nlohmann::ordered_json::array();
  for (const std::string& id : forgotten.local_maps()) ids.push_back(id);
  const std::vector<uint32_t> numbers(forgotten.numbers().begin(), forgotten.numbers().end());
  const std::string names = DescribeNumbers(arguments.agent, numbers);
  PrintResult(absl::StrCat(arguments.dry_run ? "would delete " : "deleted ",
                           forgotten.local_maps_size(), " local maps of ", arguments.agent,
                           " (and ", forgotten.parts(), " that had become parts of them), with ",
                           forgotten.keyframes(), " keyframes and ", forgotten.map_points(),
                           " points", names.empty() ? "" : ": ", names, "\n"),
              {{"dry_run", arguments.dry_run},
               {"local_maps", ids},
               {"numbers", numbers},
               {"parts", forgotten.parts()},
               {"keyframes", forgotten.keyframes()},
               {"map_points", forgotten.map_points()},
               {"stored_bytes", forgotten.stored_bytes()}});
  return absl::OkStatus();
}

}  // namespace

void AddForgetAction(CLI::App& mission, const std::shared_ptr<MissionArguments>& arguments,
                     Command& chosen) {
  CLI::App* forget = AddMissionAction(mission, "forget",
                                      "Delete a robot's old sessions: its closed local maps by "
                                      "age or number",
                                      &Forget, arguments, chosen);
  AddMissionFlag(*forget, *arguments);
  AddJsonFlag(*forget, *arguments);
  forget->add_option("--agent", arguments->agent, "The robot's name")->required();
  forget->add_option("--before", arguments->before,
                     "Those that ended before this time of the robot's clock: nanoseconds, or "
                     "2026-11-28T12:00:00Z");
  forget->add_option("--keep", arguments->keep_local_maps, "All but so many of the newest")
      ->check(CLI::Range(0, 1'000'000));
  AddYesFlag(*forget, *arguments);
  forget->add_flag("--dry-run", arguments->dry_run, "Say what would go, and delete nothing");
}

}  // namespace corbslam::services
