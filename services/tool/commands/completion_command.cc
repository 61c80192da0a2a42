#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>

#include "absl/strings/str_cat.h"
#include "services/runtime/child_process.h"
#include "services/tool/commands/commands.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// Replaces this process by `program`, which prints the completion of its own flags. Returns only if
// that fails.
absl::Status PrintCompletion(const std::string& shell, const std::string& program) {
  ASSIGN_OR_RETURN(const std::string path, FindProgramBeside(program));
  execl(path.c_str(), program.c_str(), "--completion", shell.c_str(), nullptr);
  return absl::UnavailableError(absl::StrCat("can't run ", path, ": ", std::strerror(errno)));
}

}  // namespace

void AddCompletionCommand(CLI::App& app, Command& chosen) {
  auto shell = std::make_shared<std::string>();
  auto program = std::make_shared<std::string>("corbslam");
  CLI::App* completion =
      app.add_subcommand("completion", "Print a script that completes command lines")->group("");
  completion->add_option("shell", *shell, "bash or zsh")
      ->check(CLI::IsMember({"bash", "zsh"}))
      ->required();
  completion->add_option("program", *program, "Of which of our programs")
      ->check(CLI::IsMember(
          {"corbslam", "map_store", "fusion_worker", "client_agent", "simulated_agent"}))
      ->capture_default_str();
  completion->callback([shell, program, &chosen] {
    chosen = [shell, program] { return PrintCompletion(*shell, *program); };
  });
}

}  // namespace corbslam::services
