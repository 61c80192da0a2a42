// The commands that mend and upgrade a stopped store's folder.
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "map_store/journal_repair.h"
#include "map_store/rocks/journal_rehearsal.h"
#include "services/tool/commands/commands.h"
#include "services/tool/commands/journal_actions.h"
#include "services/tool/output/result.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::MissionToUpgrade;
using map_store::RepairReport;
using map_store::SalvageReport;
using map_store::UpgradePlan;

namespace {

struct JournalArguments {
  std::string directory;
  std::string mission;
  std::string file;
  bool dry_run = false;
};

// Returns what is lost, a line each.
std::vector<std::string> DescribeLost(const SalvageReport& salvage) {
  std::vector<std::string> lost;
  if (!salvage.not_opened.ok()) {
    lost.push_back(absl::StrCat("lost: the log, and what is newer than the files that are whole (",
                                salvage.not_opened.message(), ")"));
  }
  if (!salvage.ended.ok()) {
    lost.push_back(absl::StrCat("lost: what comes after record ", salvage.last, " (",
                                salvage.ended.message(), ")"));
  }
  if (salvage.durable > salvage.last) {
    lost.push_back(absl::StrCat("lost: at least ", salvage.durable - salvage.last,
                                " records, up to ", salvage.durable, ", which was durable"));
  }
  for (const auto& [id, why] : salvage.without_features) {
    lost.push_back(absl::StrCat("keyframe ", ToString(id), " has lost its features (", why, ")"));
  }
  return lost;
}

absl::Status Repair(const JournalArguments& arguments) {
  ASSIGN_OR_RETURN(
      const RepairReport report,
      map_store::RepairMission(arguments.directory, arguments.mission, arguments.file));
  const SalvageReport& salvage = report.salvage;
  const std::vector<std::string> lost = DescribeLost(salvage);
  std::string text = absl::StrCat(
      "read: ", salvage.snapshot == 0 ? "no snapshot" : absl::StrCat("snapshot ", salvage.snapshot),
      " and ", salvage.records, " records, up to record ", salvage.last, "\n");
  for (const std::string& line : lost) absl::StrAppend(&text, line, "\n");
  absl::StrAppend(&text, arguments.file, ": mission ", arguments.mission, " with ", report.agents,
                  " agents, ", report.local_maps, " local maps, ", report.keyframes, " keyframes; ",
                  report.left_out, " keyframes were left out; ", report.bytes, " bytes\n");
  PrintResult(text, {{"mission", arguments.mission},
                     {"file", arguments.file},
                     {"bytes", report.bytes},
                     {"agents", report.agents},
                     {"local_maps", report.local_maps},
                     {"keyframes", report.keyframes},
                     {"left_out", report.left_out},
                     {"snapshot", salvage.snapshot},
                     {"records", salvage.records},
                     {"last_record", salvage.last},
                     {"lost", lost}});
  return absl::OkStatus();
}

std::string DescribePlan(const std::string& directory, const UpgradePlan& plan) {
  if (!plan.needed()) {
    return absl::StrCat(directory, " is of format ", plan.from,
                        ", this program's own: nothing is to be done\n");
  }
  std::string text;
  for (const MissionToUpgrade& mission : plan.missions) {
    absl::StrAppendFormat(&text,
                          "%s: %u records since its snapshot, features of %u keyframes; %.1f MiB\n",
                          mission.name, mission.records, mission.keyframes,
                          static_cast<double>(mission.bytes) / (1 << 20));
  }
  absl::StrAppend(&text, directory, " is of format ", plan.from, " and becomes ", plan.to, ": ",
                  plan.missions.size());
  if (plan.bytes_needed == 0) return text + " missions change where they are\n";
  absl::StrAppendFormat(&text,
                        " missions are copied, which takes %.1f MiB more for a while; the disk has "
                        "%.1f MiB free\n",
                        static_cast<double>(plan.bytes_needed) / (1 << 20),
                        static_cast<double>(plan.bytes_free) / (1 << 20));
  return text;
}

nlohmann::ordered_json PlanToJson(const UpgradePlan& plan) {
  nlohmann::ordered_json missions = nlohmann::ordered_json::array();
  for (const MissionToUpgrade& mission : plan.missions) {
    missions.push_back({{"name", mission.name},
                        {"records", mission.records},
                        {"keyframes", mission.keyframes},
                        {"bytes", mission.bytes}});
  }
  return {{"from_format", plan.from},
          {"to_format", plan.to},
          {"bytes_needed", plan.bytes_needed},
          {"bytes_free", plan.bytes_free},
          {"missions", missions}};
}

absl::Status Upgrade(const JournalArguments& arguments) {
  ASSIGN_OR_RETURN(const UpgradePlan plan, map_store::PlanUpgrade(arguments.directory));
  if (plan.from == 0) {
    return absl::FailedPreconditionError(absl::StrCat(arguments.directory, " holds no journal"));
  }
  nlohmann::ordered_json json = PlanToJson(plan);
  const bool is_done = plan.needed() && !arguments.dry_run;
  if (is_done) RETURN_IF_ERROR(map_store::UpgradeFolder(arguments.directory));
  json["upgraded"] = is_done;
  PrintResult(DescribePlan(arguments.directory, plan) +
                  (is_done ? "done: older programs don't read it any more\n" : ""),
              json);
  if (is_done || plan.bytes_free >= plan.bytes_needed) return absl::OkStatus();
  return absl::ResourceExhaustedError(absl::StrCat("the upgrade wants ", plan.bytes_needed,
                                                   " bytes and the disk has ", plan.bytes_free,
                                                   " free: make room, or move the folder"));
}

}  // namespace

void AddJournalRepair(CLI::App& journal, Command& chosen) {
  auto arguments = std::make_shared<JournalArguments>();
  CLI::App* repair = journal.add_subcommand(
      "repair",
      "Write a backup of what can be had of a damaged mission, for `mission restore`; the store "
      "must be stopped, and nothing in its folder is changed");
  repair->add_option("--data-dir", arguments->directory, "The store's folder")->required();
  repair->add_option("--mission", arguments->mission, "The damaged mission")->required();
  repair->add_option("--to", arguments->file, "File to write; there must be none yet")->required();
  repair->callback([arguments, &chosen] { chosen = [arguments] { return Repair(*arguments); }; });
}

void AddJournalUpgrade(CLI::App& journal, Command& chosen) {
  auto arguments = std::make_shared<JournalArguments>();
  CLI::App* upgrade = journal.add_subcommand(
      "upgrade",
      "Make a stopped store's folder of an older format one of this program's, as its start would");
  upgrade->add_option("--data-dir", arguments->directory, "The store's folder")->required();
  upgrade->add_flag("--dry-run", arguments->dry_run,
                    "Read all of it, say what would happen and whether there is room; change "
                    "nothing");
  upgrade->callback([arguments, &chosen] { chosen = [arguments] { return Upgrade(*arguments); }; });
}

}  // namespace corbslam::services
