// corbslam is the tool for people: it runs missions, simulates, measures, draws, and makes tokens
// and vocabularies.
#include <glog/logging.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>
#include <vector>

#include "absl/strings/str_join.h"
#include "services/command_line/command_line.h"
#include "services/simulated_source/simulated_source.h"
#include "services/tool/commands/commands.h"

int main(int argc, char** argv) {
  google::InitGoogleLogging(argv[0]);
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_WARNING;
  const std::string command_line = absl::StrJoin(std::vector<std::string>(argv, argv + argc), " ");
  corbslam::services::RegisterSimulatedSources();
  CLI::App app("Several robots, one map", "corbslam");
  app.require_subcommand(1);
  corbslam::services::Command chosen;
  corbslam::services::AddCompletionCommand(app, chosen);
  corbslam::services::AddDemoCommand(app, command_line, chosen);
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
  corbslam::services::AddTokenCommand(app, chosen);
  corbslam::services::AddVocabularyCommand(app, chosen);
  corbslam::services::CommandLine flags(&app, "tool");
  if (const auto exit_code = flags.ParseOrExit(argc, argv); exit_code.has_value()) {
    return *exit_code;
  }
  const absl::Status status = chosen();
  if (status.ok()) return 0;
  std::fprintf(stderr, "corbslam: %s\n", status.ToString().c_str());
  return 1;
}
