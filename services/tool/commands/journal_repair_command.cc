// The command that mends a stopped store's folder.
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/store/journal_repair.h"
#include "services/tool/commands/commands.h"
#include "services/tool/commands/journal_actions.h"
#include "services/tool/output/result.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::RepairReport;
using map_store::SalvageReport;

namespace {

struct JournalArguments {
  std::string directory;
  std::string mission;
  std::string file;
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

}  // namespace corbslam::services
