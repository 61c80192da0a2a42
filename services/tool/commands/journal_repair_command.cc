// The commands that mend and upgrade a stopped store's folder.
#include <cstdio>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "map_store/journal_repair.h"
#include "map_store/rocks/journal_rehearsal.h"
#include "services/tool/commands/commands.h"
#include "services/tool/commands/journal_actions.h"
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

void PrintLost(const SalvageReport& salvage) {
  if (!salvage.not_opened.ok()) {
    std::printf("lost: the log, and what is newer than the files that are whole (%s)\n",
                std::string(salvage.not_opened.message()).c_str());
  }
  if (!salvage.ended.ok()) {
    std::printf("lost: what comes after record %lu (%s)\n",
                static_cast<unsigned long>(salvage.last),
                std::string(salvage.ended.message()).c_str());
  }
  if (salvage.durable > salvage.last) {
    std::printf("lost: at least %lu records, up to %lu, which was durable\n",
                static_cast<unsigned long>(salvage.durable - salvage.last),
                static_cast<unsigned long>(salvage.durable));
  }
  for (const auto& [id, why] : salvage.without_features) {
    std::printf("keyframe %s has lost its features (%s)\n", ToString(id).c_str(), why.c_str());
  }
}

absl::Status Repair(const JournalArguments& arguments) {
  ASSIGN_OR_RETURN(
      const RepairReport report,
      map_store::RepairMission(arguments.directory, arguments.mission, arguments.file));
  const SalvageReport& salvage = report.salvage;
  std::printf(
      "read: %s and %lu records, up to record %lu\n",
      salvage.snapshot == 0 ? "no snapshot" : absl::StrCat("snapshot ", salvage.snapshot).c_str(),
      static_cast<unsigned long>(salvage.records), static_cast<unsigned long>(salvage.last));
  PrintLost(salvage);
  std::printf(
      "%s: mission %s with %zu agents, %zu local maps, %zu keyframes; %zu keyframes were left out; "
      "%lu bytes\n",
      arguments.file.c_str(), arguments.mission.c_str(), report.agents, report.local_maps,
      report.keyframes, report.left_out, static_cast<unsigned long>(report.bytes));
  return absl::OkStatus();
}

void PrintPlan(const std::string& directory, const UpgradePlan& plan) {
  for (const MissionToUpgrade& mission : plan.missions) {
    std::printf("%s: %lu records since its snapshot, features of %lu keyframes; %.1f MiB\n",
                mission.name.c_str(), static_cast<unsigned long>(mission.records),
                static_cast<unsigned long>(mission.keyframes),
                static_cast<double>(mission.bytes) / (1 << 20));
  }
  if (plan.bytes_needed == 0) {
    std::printf("%s is of format %u and becomes %u: %zu missions change where they are\n",
                directory.c_str(), plan.from, plan.to, plan.missions.size());
    return;
  }
  std::printf(
      "%s is of format %u and becomes %u: %zu missions are copied, which takes %.1f MiB more for a "
      "while; the disk has %.1f MiB free\n",
      directory.c_str(), plan.from, plan.to, plan.missions.size(),
      static_cast<double>(plan.bytes_needed) / (1 << 20),
      static_cast<double>(plan.bytes_free) / (1 << 20));
}

absl::Status Upgrade(const JournalArguments& arguments) {
  ASSIGN_OR_RETURN(const UpgradePlan plan, map_store::PlanUpgrade(arguments.directory));
  if (plan.from == 0) {
    return absl::FailedPreconditionError(absl::StrCat(arguments.directory, " holds no journal"));
  }
  if (!plan.needed()) {
    std::printf("%s is of format %u, this program's own: nothing is to be done\n",
                arguments.directory.c_str(), plan.from);
    return absl::OkStatus();
  }
  PrintPlan(arguments.directory, plan);
  if (!arguments.dry_run) {
    RETURN_IF_ERROR(map_store::UpgradeFolder(arguments.directory));
    std::printf("done: older programs don't read it any more\n");
    return absl::OkStatus();
  }
  if (plan.bytes_free >= plan.bytes_needed) return absl::OkStatus();
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
