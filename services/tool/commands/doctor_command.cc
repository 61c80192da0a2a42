#include <cstdio>
#include <memory>

#include "absl/time/clock.h"
#include "client_agent/live/live_sources.h"
#include "services/client/reachability/cause.h"
#include "services/command_line/command_line.h"
#include "services/programs/default_vocabulary.h"
#include "services/security/certificate_checks.h"
#include "services/security/flags.h"
#include "services/tool/commands/commands.h"
#include "services/tool/doctor/database_checks.h"
#include "services/tool/doctor/local_checks.h"
#include "services/tool/doctor/server_checks.h"

namespace corbslam::services {
namespace {

struct DoctorArguments {
  std::string server;
  std::vector<std::string> workers;
  std::string data_dir;
  JournalFlags journal;
  std::string source;
  std::string vocabulary = DefaultVocabularyPath();
  SecurityOptions security;
  bool json = false;
  bool strict = false;
};

void Add(const Findings& more, Findings& findings) {
  findings.insert(findings.end(), more.begin(), more.end());
}

// Checks only what the flags name, and what every program needs.
Findings Examine(const DoctorArguments& arguments) {
  const absl::Time now = absl::Now();
  Findings findings = {{Level::kOk, "version", ProgramVersion(), ""}};
  Add(CheckClock(now), findings);
  Add({CheckVocabularyFile(arguments.vocabulary)}, findings);
  if (!arguments.data_dir.empty()) Add(CheckDataFolder(arguments.data_dir), findings);
  if (!arguments.journal.journal.empty()) Add(CheckDatabase(arguments.journal), findings);
  if (!arguments.source.empty()) Add(CheckSource(arguments.source, arguments.strict), findings);
  Add(CheckSecurityFiles(arguments.security, now), findings);
  if (!arguments.server.empty()) {
    Add(CheckServer("store", arguments.server, kMapStoreService, arguments.security, now),
        findings);
  }
  for (const std::string& worker : arguments.workers) {
    Add(CheckServer("worker", worker, kFusionWorkerService, arguments.security, now), findings);
  }
  return findings;
}

absl::Status RunDoctor(const DoctorArguments& arguments) {
  client_agent::RegisterLiveSources();
  const Findings findings = Examine(arguments);
  std::fputs((arguments.json ? ToJson(findings).dump(2) + "\n" : FormatFindings(findings)).c_str(),
             stdout);
  if (!AnyFailed(findings)) return absl::OkStatus();
  return absl::FailedPreconditionError("something is wrong: see the lines that say fail");
}

}  // namespace

void AddDoctorCommand(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<DoctorArguments>();
  CLI::App* doctor = app.add_subcommand("doctor", "Look for what is wrong before a mission does");
  doctor->add_option("--server", arguments->server, "HOST:PORT of a map store to ask");
  doctor->add_option("--worker", arguments->workers, "HOST:PORT of a fusion worker to ask")
      ->delimiter(',');
  doctor->add_option("--data-dir", arguments->data_dir, "Folder of a store to look into");
  doctor->add_option("--journal", arguments->journal.journal,
                     "Database of stores to look into: postgres:URI");
  doctor->add_option("--journal-password-file", arguments->journal.password_file,
                     "File with the database's password alone");
  doctor->add_option("--source", arguments->source, "Sequence to look into, as for a robot");
  doctor->add_option("--vocabulary", arguments->vocabulary, "File of the bag of words")
      ->capture_default_str();
  AddTlsFlags(*doctor, arguments->security);
  AddClientFlags(*doctor, arguments->security);
  doctor->add_flag("--strict", arguments->strict, "What looks wrong in a source is a failure");
  doctor->add_flag("--json", arguments->json, "Print JSON, for scripts");
  doctor->callback(
      [arguments, &chosen] { chosen = [arguments] { return RunDoctor(*arguments); }; });
}

}  // namespace corbslam::services
