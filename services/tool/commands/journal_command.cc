#include <cstdio>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "map_store/journal_check.h"
#include "services/tool/commands/commands.h"
#include "services/tool/commands/journal_actions.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::CheckedMission;

namespace {

void PrintMission(const CheckedMission& mission) {
  if (!mission.status.ok()) {
    std::printf("%s: DAMAGED: %s\n", mission.name.c_str(),
                std::string(mission.status.message()).c_str());
    return;
  }
  std::printf("%s: fine: %zu agents, %zu local maps, %zu keyframes; %.1f MiB\n",
              mission.name.c_str(), mission.agents, mission.local_maps, mission.keyframes,
              static_cast<double>(mission.disk_bytes) / (1 << 20));
}

absl::Status CheckFolder(const std::string& directory) {
  int missions = 0;
  int damaged = 0;
  RETURN_IF_ERROR(map_store::CheckJournal(directory, [&](const CheckedMission& mission) {
    PrintMission(mission);
    ++missions;
    damaged += mission.status.ok() ? 0 : 1;
  }));
  if (damaged == 0) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat(
      damaged, " of ", missions, " missions in ", directory,
      " are damaged: a store that starts has the others. docs/journal.md says what to do"));
}

}  // namespace

void AddJournalCommand(CLI::App& app, Command& chosen) {
  CLI::App* journal = app.add_subcommand("journal", "Look at a stopped store's folder, mend and upgrade it");
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
  AddJournalUpgrade(*journal, chosen);
}

}  // namespace corbslam::services
