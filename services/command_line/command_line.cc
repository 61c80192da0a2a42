#include "services/command_line/command_line.h"

#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "services/command_line/advice.h"
#include "services/command_line/environment.h"
#include "services/command_line/help_formatter.h"
#include "services/command_line/man_page.h"
#include "services/command_line/secrets.h"
#include "services/command_line/values.h"

namespace corbslam::services {
namespace {

std::string GetVariable(const std::string& name) {
  const char* value = name.empty() ? nullptr : std::getenv(name.c_str());
  return value == nullptr ? "" : value;
}

void SetFormatter(CLI::App& app, const std::shared_ptr<HelpFormatter>& formatter) {
  app.formatter(formatter);
  for (CLI::App* command : app.get_subcommands(nullptr)) SetFormatter(*command, formatter);
}

// Returns true if the message has the flag's name, and not only as the beginning of a longer one.
bool Names(const std::string& message, const CLI::Option& option) {
  if (option.get_lnames().empty()) return false;
  const std::string flag = "--" + option.get_lnames()[0];
  const size_t at = message.find(flag);
  if (at == std::string::npos) return false;
  const size_t end = at + flag.size();
  return end == message.size() || (message[end] != '-' && std::isalnum(message[end]) == 0);
}

// Advises on words that are missing or unknown; empty if the error's own text must do.
std::string AdviseOn(const CLI::ParseError& error, const CLI::App& app) {
  const auto code = static_cast<CLI::ExitCodes>(error.get_exit_code());
  if (code != CLI::ExitCodes::RequiredError && code != CLI::ExitCodes::ExtrasError) return "";
  const std::string advice = DescribeWrongCommand(app);
  return advice.empty() ? DescribeWrongFlag(app) : advice;
}

// Returns true if the option has neither a value nor a default: its line would say that it is "".
bool IsUnset(const CLI::App& app, const std::string& name) {
  const CLI::Option* option = app.get_option_no_throw("--" + name);
  return option != nullptr && option->get_expected_min() > 0 && option->count() == 0 &&
         option->get_default_str().empty();
}

// CLI11 lets through what the standard library throws at a switch's value.
void ParseWithoutOthersExceptions(CLI::App& app, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::Error&) {
    throw;
  } catch (const std::exception&) {
    throw CLI::ConversionError("a switch has a value that is neither true nor false");
  }
}

bool HasRareFlags(const CLI::App& app) {
  for (const std::string& group : app.get_groups()) {
    if (group == kRareGroup) return true;
  }
  return false;
}

}  // namespace

std::string ProgramVersion() { return CORBSLAM_VERSION; }

CommandLine::CommandLine(CLI::App* app, const std::string& program)
    : app_(app), prefix_(EnvironmentPrefix(program)), file_(std::make_shared<ConfigFile>(app)) {
  const std::string path = GetVariable(prefix_ + "CONFIG");
  app_->set_config("--config", path, "File with flags, in TOML: name = value", !path.empty())
      ->type_name("FILE")
      ->configurable(false);
  app_->config_formatter(file_);
  app_->allow_config_extras(CLI::config_extras_mode::error);
  app_->set_version_flag("--version", ProgramVersion(), "Print the version and exit")
      ->configurable(false);
  app_->set_help_flag("-h,--help", "Print this and exit")->configurable(false);
  if (HasRareFlags(*app_)) {
    app_->set_help_all_flag("--help-all", "With what is rarely needed, too")->configurable(false);
  }
  app_->footer(absl::StrCat("\nFlags count before environment variables (", prefix_,
                            "FLAG for --flag, dashes as\nunderscores), those before the file of "
                            "--config, that before the [defaults]."));
  app_->add_flag_callback("--man-page",
                          [=, this] {
                            throw CLI::CallForVersion(
                                FormatManPage(*app_, prefix_, ProgramVersion()), 0);
                          })
      ->group("")
      ->configurable(false);
  SetFormatter(*app_, std::make_shared<HelpFormatter>());
  ReadFromEnvironment(*app_, prefix_);
  CheckEveryValue(*app_);
}

void CommandLine::CheckEnvironment() const {
  const std::string unknown = DescribeUnknownVariables(*app_, prefix_);
  if (!unknown.empty()) throw CLI::ConfigError(unknown);
}

void CommandLine::Parse(int argc, const char* const* argv) {
  try {
    ParseWithoutOthersExceptions(*app_, argc, argv);
    CheckEnvironment();
  } catch (const CLI::Success&) {
    throw;
  } catch (const CLI::ParseError& error) {
    const std::string said = Rephrased(error.what());
    const std::string sources = SourcesOf(said);
    if (sources.empty() && said == error.what()) throw;
    throw CLI::ParseError(
        absl::StrCat(said, sources.empty() ? "" : " (", sources, sources.empty() ? "" : ")"),
        error.get_exit_code());
  }
}

std::optional<int> CommandLine::ParseOrExit(
    int argc, const char* const* argv, const std::function<void(const std::string&)>& say_wrong) {
  try {
    Parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app_->exit(success);
  } catch (const CLI::ParseError& error) {
    const std::string advice = AdviseOn(error, *app_);
    if (say_wrong != nullptr) {
      say_wrong(advice.empty() ? error.what() : advice);
    } else if (advice.empty()) {
      app_->exit(error);
    } else {
      std::fputs(advice.c_str(), stderr);
    }
    return kWrongUsage;
  }
  return std::nullopt;
}

std::string CommandLine::Source(const CLI::Option& option) const {
  if (option.get_lnames().empty() || !option.get_configurable()) return "";
  const auto place = file_->places().find(option.get_lnames()[0]);
  if (place != file_->places().end() && option.count() > 0) return place->second;
  const std::string value = GetVariable(option.get_envname());
  if (!value.empty() && absl::StrJoin(option.results(), ",") == value) return option.get_envname();
  return option.count() > 0 ? "command line" : "";
}

std::string CommandLine::SourcesOf(const std::string& message) {
  std::vector<std::string> sources;
  ForEachOption(*app_, [&](CLI::App&, CLI::Option& option) {
    const std::string source = Names(message, option) ? Source(option) : "";
    if (!source.empty() && source != "command line") sources.push_back(source);
  });
  return absl::StrJoin(sources, ", ");
}

std::string CommandLine::DescribeConfiguration() {
  std::map<std::string, std::string> sources;
  ForEachOption(*app_, [&](CLI::App&, CLI::Option& option) {
    const std::string source = Source(option);
    if (!source.empty()) sources[option.get_lnames()[0]] = source;
  });
  std::string text;
  std::set<std::string> shown;
  const std::string values = app_->config_to_str(/*default_also=*/true);
  for (const absl::string_view line : absl::StrSplit(values, '\n', absl::SkipEmpty())) {
    const std::string name(line.substr(0, line.find('=')));
    if (IsUnset(*app_, name)) continue;
    const auto source = sources.find(name);
    absl::StrAppend(&text, HideSecrets(std::string(line)),
                    source == sources.end() ? "" : absl::StrCat("  # ", source->second), "\n");
    shown.insert(name);
  }
  for (const CLI::Option* option : app_->get_options()) {
    const bool is_setting = option->get_configurable() && !option->get_lnames().empty();
    if (!is_setting || shown.contains(option->get_lnames()[0])) continue;
    absl::StrAppend(&text, "# ", option->get_lnames()[0], " is not set\n");
  }
  return text;
}

}  // namespace corbslam::services
