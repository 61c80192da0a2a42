// The commands below `corbslam journal` that change something, each in its file.
#ifndef CORBSLAM_SERVICES_TOOL_COMMANDS_JOURNAL_ACTIONS_H_
#define CORBSLAM_SERVICES_TOOL_COMMANDS_JOURNAL_ACTIONS_H_

#include <CLI/CLI.hpp>

#include "services/tool/commands/commands.h"

namespace corbslam::services {

void AddJournalRepair(CLI::App& journal, Command& chosen);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_COMMANDS_JOURNAL_ACTIONS_H_
