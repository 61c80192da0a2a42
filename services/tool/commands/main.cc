// corbslam is the tool for people: it runs missions, simulates, measures, draws, and makes tokens
// and vocabularies.
#include <glog/logging.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_join.h"
#include "client_agent/source/bag/bag_source.h"
#include "services/command_line/command_line.h"
#include "services/observe/logging/log_format.h"
#include "services/simulated_source/simulated_source.h"
#include "services/tool/commands/commands.h"
#include "services/tool/output/result.h"

int main(int argc, char** argv) {
  corbslam::services::StartLogging(argv[0], corbslam::services::LogFormat::kText);
  FLAGS_minloglevel = google::GLOG_WARNING;
  const std::string command_line = absl::StrJoin(std::vector<std::string>(argv, argv + argc), " ");
  corbslam::services::RegisterSimulatedSources();
  corbslam::client_agent::RegisterBagSource();
  CLI::App app("Several robots, one map", "corbslam");
  app.require_subcommand(1);
  corbslam::services::Command chosen;
  corbslam::services::AddDemoCommand(app, command_line, chosen);
  corbslam::services::AddBagCommand(app, chosen);
  corbslam::services::AddDoctorCommand(app, chosen);
  corbslam::services::AddRunCommand(app, command_line, chosen);
  corbslam::services::AddMissionCommand(app, chosen);
  corbslam::services::AddEvalCommand(app, chosen);
  corbslam::services::AddJournalCommand(app, chosen);
  corbslam::services::AddLocalizeCommand(app, chosen);
  corbslam::services::AddRenderCommand(app, chosen);
  corbslam::services::AddReplayCommand(app, chosen);
  corbslam::services::AddRigCommand(app, chosen);
  corbslam::services::AddSimulateCommand(app, chosen);
  corbslam::services::AddSplitCommand(app, chosen);
  corbslam::services::AddStoreSchemaCommand(app, chosen);
  corbslam::services::AddFleetCommand(app, chosen);
  corbslam::services::AddTokenCommand(app, chosen);
  corbslam::services::AddVocabularyCommand(app, chosen);
  corbslam::services::AddJsonFlags(app);
  corbslam::services::CommandLine flags(&app, "tool");
  const auto say_wrong = [](const std::string& what) {
    corbslam::services::PrintError(absl::InvalidArgumentError(what), /*json=*/true);
  };
  const auto exit_code = corbslam::services::AsksForJson(argc, argv)
                             ? flags.ParseOrExit(argc, argv, say_wrong)
                             : flags.ParseOrExit(argc, argv);
  if (exit_code.has_value()) return *exit_code;
  corbslam::services::SetWantsJson(corbslam::services::AsksForJson(app));
  const absl::Status status = chosen();
  if (status.ok()) return 0;
  corbslam::services::PrintError(status, corbslam::services::WantsJson());
  return 1;
}
