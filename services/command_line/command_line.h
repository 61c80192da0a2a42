// How a program is told what to do. A value on the command line counts before one in the
// environment, that before one in the file of --config, that before the default. What means no flag
// is refused by name wherever it stands.
#ifndef CORBSLAM_SERVICES_COMMAND_LINE_COMMAND_LINE_H_
#define CORBSLAM_SERVICES_COMMAND_LINE_COMMAND_LINE_H_

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>

#include "services/command_line/config_file.h"

namespace corbslam {

// Of all programs, as "0.1.0".
std::string ProgramVersion();

// Not thread-safe. Adds what every program has: --config, --version, --help-all, and, for packagers
// and not in --help, --man-page and --completion bash|zsh.
class CommandLine {
 public:
  // All flags and commands must have been added. Variables are called CORBSLAM_PROGRAM_FLAG. The
  // app outlives it.
  CommandLine(CLI::App* app, const std::string& program);

  // Sets what the options are bound to. Otherwise throws CLI::ParseError (or its success, after
  // --help), which says where a wrong value stands.
  void Parse(int argc, const char* const* argv);
  // The same, with what was thrown printed; the program's exit code, or none: it goes on.
  std::optional<int> ParseOrExit(int argc, const char* const* argv);

  // Every flag's value, in the file's form; then which flags were set, and where. Values are names
  // of files at most: nothing secret is in a flag.
  std::string DescribeConfiguration();

 private:
  void AddPrinters();
  void CheckEnvironment() const;
  // Where its value stands: "command line", a variable or FILE:LINE; "" for a default.
  std::string Source(const CLI::Option& option) const;
  // The sources of the flags that a message names.
  std::string SourcesOf(const std::string& message);

  CLI::App* const app_;
  const std::string prefix_;
  std::shared_ptr<ConfigFile> file_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_COMMAND_LINE_COMMAND_LINE_H_
