#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "map_store/store/journal_check.h"
#include "services/tool/commands/commands.h"
#include "services/tool/commands/journal_actions.h"
#include "services/tool/output/progress.h"
#include "services/tool/output/result.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::CheckedMission;

namespace {

std::string Format(const CheckedMission& mission) {
  if (!mission.status.ok()) {
    return absl::StrCat(mission.name, ": DAMAGED: ", mission.status.message(), "\n");
  }
  std::string text = absl::StrFormat(
      "%s: fine: %d agents, %d local maps, %d keyframes; %.1f MiB\n", mission.name, mission.agents,
      mission.local_maps, mission.keyframes, static_cast<double>(mission.disk_bytes) / (1 << 20));
  for (const std::string& note : mission.notes) absl::StrAppend(&text, "  note: ", note, "\n");
  return text;
}

nlohmann::ordered_json CheckedToJson(const CheckedMission& mission) {
  nlohmann::ordered_json json = {
      {"mission", mission.name}, {"damage", nullptr}, {"disk_bytes", mission.disk_bytes}};
  json["notes"] = mission.notes;
  if (!mission.status.ok()) {
    json["damage"] = std::string(mission.status.message());
    return json;
  }
  json["agents"] = mission.agents;
  json["local_maps"] = mission.local_maps;
  json["keyframes"] = mission.keyframes;
  return json;
}

absl::Status CheckFolder(const std::string& directory) {
  int missions = 0;
  int damaged = 0;
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  {
    ProgressTicker ticker("reads the first mission");
    RETURN_IF_ERROR(map_store::CheckJournal(directory, [&](const CheckedMission& mission) {
      Say(Format(mission));
      rows.push_back(CheckedToJson(mission));
      ++missions;
      damaged += mission.status.ok() ? 0 : 1;
      ticker.Set(absl::StrCat("read ", missions, missions == 1 ? " mission" : " missions"));
    }));
  }
  PrintResult("", rows);
  if (damaged == 0) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat(
      damaged, " of ", missions, " missions in ", directory,
      " are damaged: a store that starts has the others. docs/journal.md says what to do"));
}

}  // namespace

void AddJournalCommand(CLI::App& app, Command& chosen) {
  CLI::App* journal = app.add_subcommand("journal", "Look at a stopped store's folder and mend it");
  journal->require_subcommand(1);
  CLI::App* check = journal->add_subcommand(
      "check",
      "Read all that is in it, and say which missions are damaged; the store must be "
      "stopped, and nothing of its missions is changed");
  auto directory = std::make_shared<std::string>();
  check->add_option("--data-dir", *directory, "The store's folder")->required();
  check->callback(
      [directory, &chosen] { chosen = [directory] { return CheckFolder(*directory); }; });
  AddJournalRepair(*journal, chosen);
}

}  // namespace corbslam::services
