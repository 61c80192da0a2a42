#include "services/command_line/environment.h"

#include <unistd.h>

#include <set>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"

namespace corbslam::services {
namespace {

std::string ToVariable(absl::string_view name) {
  return absl::StrReplaceAll(absl::AsciiStrToUpper(name), {{"-", "_"}});
}

bool IsOfKubernetes(absl::string_view rest) {
  return rest == "PORT" || absl::StartsWith(rest, "PORT_") || absl::StartsWith(rest, "SERVICE_");
}

std::vector<std::string> ListVariables(absl::string_view prefix) {
  std::vector<std::string> names;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    if (absl::StartsWith(*entry, prefix)) {
      names.emplace_back(std::vector<std::string>(absl::StrSplit(*entry, '='))[0]);
    }
  }
  return names;
}

}  // namespace

std::string EnvironmentPrefix(absl::string_view program) {
  return absl::StrCat("CORBSLAM_", ToVariable(program), "_");
}

std::string EnvironmentName(absl::string_view prefix, const CLI::Option& option) {
  if (!option.get_configurable() || option.get_lnames().empty()) return "";
  return absl::StrCat(prefix, ToVariable(option.get_lnames()[0]));
}

void ForEachOption(CLI::App& app, const std::function<void(CLI::App&, CLI::Option&)>& visit) {
  for (CLI::Option* option : app.get_options()) visit(app, *option);
  for (CLI::App* command : app.get_subcommands(nullptr)) ForEachOption(*command, visit);
}

void ReadFromEnvironment(CLI::App& app, const std::string& prefix) {
  ForEachOption(app, [&](CLI::App&, CLI::Option& option) {
    option.envname(EnvironmentName(prefix, option));
  });
}

std::string DescribeUnknownVariables(CLI::App& app, const std::string& prefix) {
  // --config is read before all else, and so is not among the others.
  std::set<std::string> known = {absl::StrCat(prefix, "CONFIG")};
  ForEachOption(
      app, [&](CLI::App&, CLI::Option& option) { known.insert(EnvironmentName(prefix, option)); });
  std::vector<std::string> unknown;
  for (const std::string& name : ListVariables(prefix)) {
    const bool ours = !IsOfKubernetes(absl::StripPrefix(name, prefix));
    if (ours && !known.contains(name)) unknown.push_back(name);
  }
  if (unknown.empty()) return "";
  return absl::StrCat("the environment variable ", absl::StrJoin(unknown, ", "),
                      " means no flag of this program");
}

}  // namespace corbslam::services
