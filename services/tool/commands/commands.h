// Declares the tool's commands; each adds itself to the command line.
#ifndef CORBSLAM_SERVICES_TOOL_COMMANDS_COMMANDS_H_
#define CORBSLAM_SERVICES_TOOL_COMMANDS_COMMANDS_H_

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "absl/status/status.h"

namespace corbslam::services {

// Runs the command that was chosen.
using Command = std::function<absl::Status()>;

// Each function sets `chosen` when its sub-command is on the command line.
void AddMissionCommand(CLI::App& app, Command& chosen);
void AddRunCommand(CLI::App& app, const std::string& command_line, Command& chosen);
// Adds `demo`, which is `run` of a simulated town and prints the report.
void AddDemoCommand(CLI::App& app, const std::string& command_line, Command& chosen);
// Adds `bag info`, which looks into a ROS bag.
void AddBagCommand(CLI::App& app, Command& chosen);
void AddDoctorCommand(CLI::App& app, Command& chosen);
void AddEvalCommand(CLI::App& app, Command& chosen);
// Adds `journal check`, which reads a stopped store's folder.
void AddJournalCommand(CLI::App& app, Command& chosen);
void AddRenderCommand(CLI::App& app, Command& chosen);
void AddLocalizeCommand(CLI::App& app, Command& chosen);
void AddReplayCommand(CLI::App& app, Command& chosen);
void AddRigCommand(CLI::App& app, Command& chosen);
void AddSimulateCommand(CLI::App& app, Command& chosen);
// Adds `store-schema`, which prints the SQL of a journal's tables.
void AddStoreSchemaCommand(CLI::App& app, Command& chosen);
void AddFleetCommand(CLI::App& app, Command& chosen);
void AddSplitCommand(CLI::App& app, Command& chosen);
void AddTokenCommand(CLI::App& app, Command& chosen);
void AddVocabularyCommand(CLI::App& app, Command& chosen);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_COMMANDS_COMMANDS_H_
