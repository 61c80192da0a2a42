// Tells a program what to do. A value on the command line counts before one in the environment,
// that before one in the file of --config, that before the default. What means no flag is refused
// by name wherever it stands.
#ifndef CORBSLAM_SERVICES_COMMAND_LINE_COMMAND_LINE_H_
#define CORBSLAM_SERVICES_COMMAND_LINE_COMMAND_LINE_H_

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "services/command_line/config_file.h"

namespace corbslam::services {

// What programs end with after a wrong flag, command or value: nothing was started
// (docs/exit_codes.md).
inline constexpr int kWrongUsage = 2;

// Returns the version of all programs, such as "0.1.0".
std::string ProgramVersion();

// Parses one program's flags. Not thread-safe. Adds what every program has: --config, --version,
// --help-all, and, for packagers and not in --help, --man-page.
class CommandLine {
 public:
  // The caller must have added all flags and commands. Variables are called CORBSLAM_PROGRAM_FLAG.
  // The app must outlive this object.
  CommandLine(CLI::App* app, const std::string& program);

  // Sets what the options are bound to, or throws CLI::ParseError (or its success, after --help),
  // which says where a wrong value stands.
  void Parse(int argc, const char* const* argv);
  // Does the same and prints what was thrown. Returns the program's exit code, 0 or kWrongUsage;
  // nullopt if the program goes on.
  // What is wrong goes to standard error, or to `say_wrong`.
  std::optional<int> ParseOrExit(
      int argc, const char* const* argv,
      const std::function<void(const std::string&)>& say_wrong = nullptr);

  // Returns every flag's value in the file's form, a line each, behind it where it was set (as a
  // comment) unless it is a default; then those that have no value, as comments. Secrets are in
  // files, whose names are shown; of a value that has one in itself, as a camera's URL, it is left
  // out (secrets.h).
  std::string DescribeConfiguration();

 private:
  void CheckEnvironment() const;
  // Returns where the option's value stands: "command line", a variable or FILE:LINE; "" for a
  // default.
  std::string Source(const CLI::Option& option) const;
  // Returns where the values of the flags that a message names stand, but for the command line.
  std::string SourcesOf(const std::string& message);

  CLI::App* const app_;
  const std::string prefix_;
  std::shared_ptr<ConfigFile> file_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_COMMAND_LINE_COMMAND_LINE_H_
