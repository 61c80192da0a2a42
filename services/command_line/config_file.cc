#include "services/command_line/config_file.h"

#include <cstdlib>
#include <iterator>
#include <sstream>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "services/command_line/environment.h"

namespace corbslam::services {
namespace {

bool IsSetByEnvironment(const CLI::Option& option) {
  const std::string name = option.get_envname();
  const char* value = name.empty() ? nullptr : std::getenv(name.c_str());
  return value != nullptr && *value != '\0';
}

// Returns true for the section marks that CLI11 puts between the items.
bool IsMark(const CLI::ConfigItem& item) { return item.name == "++" || item.name == "--"; }

absl::string_view KeyOf(absl::string_view line) {
  const absl::string_view key =
      absl::StripAsciiWhitespace(line.substr(0, line.find_first_of("=#")));
  return absl::StripSuffix(absl::StripPrefix(key, "\""), "\"");
}

CLI::Option* FindFlag(CLI::App& app, const std::string& name) {
  CLI::Option* option = app.get_option_no_throw("--" + name);
  return option != nullptr && option->get_configurable() ? option : nullptr;
}

CLI::App* FindCommand(CLI::App* app, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (app == nullptr) return nullptr;
    const std::vector<CLI::App*> found =
        app->get_subcommands([&](CLI::App* command) { return command->get_name() == name; });
    app = found.empty() ? nullptr : found[0];
  }
  return app;
}

// Returns true if any command of the program has the flag.
bool IsFlagOfSome(CLI::App& app, const std::string& name) {
  bool found = false;
  ForEachOption(app, [&](CLI::App& owner, CLI::Option&) {
    found = found || FindFlag(owner, name) != nullptr;
  });
  return found;
}

// Returns the command that was called, as the names that lead to it.
std::vector<std::string> CalledCommand(CLI::App* app) {
  std::vector<std::string> names;
  while (!app->get_subcommands().empty()) {
    app = app->get_subcommands()[0];
    names.push_back(app->get_name());
  }
  return names;
}

}  // namespace

std::string ConfigFile::Place(const std::string& text, const CLI::ConfigItem& item) const {
  const std::string path = app_->get_config_ptr()->as<std::string>();
  const std::string wanted = absl::StrJoin(item.parents, ".");
  absl::string_view section;
  int number = 0;
  for (const absl::string_view line : absl::StrSplit(text, '\n')) {
    ++number;
    const absl::string_view key = KeyOf(line);
    if (absl::StartsWith(key, "[")) section = absl::StripSuffix(key.substr(1), "]");
    if (section == wanted && key == item.name) return absl::StrCat(path, ":", number);
  }
  return path;
}

CLI::App* ConfigFile::FindOwner(CLI::ConfigItem& item) const {
  CLI::App* owner = FindCommand(app_, item.parents);
  if (owner == nullptr || FindFlag(*owner, item.name) != nullptr || !item.parents.empty()) {
    return owner;
  }
  const std::vector<std::string> called = CalledCommand(app_);
  CLI::App* command = FindCommand(app_, called);
  if (FindFlag(*command, item.name) == nullptr) return owner;
  item.parents = called;
  return command;
}

std::vector<CLI::ConfigItem> ConfigFile::from_config(std::istream& input) const {
  const std::string text{std::istreambuf_iterator<char>(input), std::istreambuf_iterator<char>()};
  std::istringstream stream(text);
  std::vector<CLI::ConfigItem> taken;
  for (CLI::ConfigItem& item : CLI::ConfigTOML::from_config(stream)) {
    if (IsMark(item)) continue;
    const std::string place = Place(text, item);
    CLI::App* owner = FindOwner(item);
    CLI::Option* option = owner == nullptr ? nullptr : FindFlag(*owner, item.name);
    if (option == nullptr) {
      if (item.parents.empty() && IsFlagOfSome(*app_, item.name)) continue;
      throw CLI::ConfigError(
          absl::StrCat(place, ": \"", item.fullname(), "\" is no flag of this program"));
    }
    if (option->count() > 0 || IsSetByEnvironment(*option)) continue;
    places_[option->get_lnames()[0]] = place;
    taken.push_back(item);
  }
  return taken;
}

}  // namespace corbslam::services
