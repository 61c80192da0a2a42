#include "services/command_line/completion.h"

#include <functional>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "services/command_line/help_formatter.h"

namespace corbslam::services {
namespace {

// Calls `visit` with each command and the words that lead to it; "" is the program itself.
void ForEachCommand(const CLI::App& app, const std::string& path,
                    const std::function<void(const CLI::App&, const std::string&)>& visit) {
  visit(app, path);
  for (const CLI::App* command : app.get_subcommands({})) {
    const std::string below = absl::StrCat(path, path.empty() ? "" : " ", command->get_name());
    if (!command->get_group().empty()) ForEachCommand(*command, below, visit);
  }
}

std::vector<const CLI::Option*> ShownOptions(const CLI::App& app) {
  return app.get_options([](const CLI::Option* option) {
    return !option->get_group().empty() && option->nonpositional();
  });
}

std::vector<std::string> Flags(const CLI::Option& option) {
  std::vector<std::string> flags;
  for (const std::string& name : option.get_lnames()) flags.push_back("--" + name);
  return flags;
}

std::vector<std::string> Words(const CLI::App& app) {
  std::vector<std::string> words;
  for (const CLI::App* command : app.get_subcommands({})) {
    if (!command->get_group().empty()) words.push_back(command->get_name());
  }
  for (const CLI::Option* option : ShownOptions(app)) {
    for (const std::string& flag : Flags(*option)) words.push_back(flag);
  }
  return words;
}

// Returns the shell's cases that say which word leads from one command to one below it.
std::string FollowCases(const CLI::App& app) {
  std::string cases;
  ForEachCommand(app, "", [&](const CLI::App& command, const std::string& path) {
    for (const CLI::App* below : command.get_subcommands({})) {
      if (below->get_group().empty()) continue;
      absl::StrAppend(&cases, "      \"", path, ":", below->get_name(), "\") command=\"", path,
                      path.empty() ? "" : " ", below->get_name(), "\" ;;\n");
    }
  });
  return cases;
}

// Returns the shell's cases that say what follows a flag that takes a value.
std::string ValueCases(const CLI::App& app) {
  std::string cases;
  ForEachCommand(app, "", [&](const CLI::App& command, const std::string& path) {
    for (const CLI::Option* option : ShownOptions(command)) {
      if (option->get_type_size() == 0) continue;
      for (const std::string& flag : Flags(*option)) {
        absl::StrAppend(&cases, "    \"", path, ":", flag, "\") COMPREPLY=($(compgen -W \"",
                        absl::StrJoin(Choices(*option), " "), "\" -- \"$cur\")); return ;;\n");
      }
    }
  });
  return cases;
}

std::string WordCases(const CLI::App& app) {
  std::string cases;
  ForEachCommand(app, "", [&](const CLI::App& command, const std::string& path) {
    absl::StrAppend(&cases, "    \"", path, "\") words=\"", absl::StrJoin(Words(command), " "),
                    "\" ;;\n");
  });
  return cases;
}

std::string FunctionName(const CLI::App& app) { return "_corbslam_complete_" + app.get_name(); }

std::string Function(const CLI::App& app) {
  return absl::StrCat(FunctionName(app), R"(() {
  local cur="${COMP_WORDS[COMP_CWORD]}" prev="${COMP_WORDS[COMP_CWORD-1]}"
  local command="" words="" word
  for word in "${COMP_WORDS[@]:1:$((COMP_CWORD - 1))}"; do
    case "$command:$word" in
)",
                      FollowCases(app), R"(      *) ;;
    esac
  done
  COMPREPLY=()
  case "$command:$prev" in
)",
                      ValueCases(app), R"(    *) ;;
  esac
  case "$command" in
)",
                      WordCases(app), R"(    *) ;;
  esac
  COMPREPLY=($(compgen -W "$words" -- "$cur"))
}
)");
}

std::string Register(const CLI::App& app) {
  return absl::StrCat("complete -o default -F ", FunctionName(app), " ", app.get_name(), "\n");
}

}  // namespace

std::vector<std::string> Choices(const CLI::Option& option) {
  const std::string name = ValueName(option);
  if (absl::StrContains(name, "|")) return absl::StrSplit(name, '|');
  // CLI::IsMember describes itself as "TEXT:{se3,sim3}".
  const std::string type = option.get_type_name();
  const size_t begin = type.find('{');
  const size_t end = type.find('}');
  if (begin == std::string::npos || end == std::string::npos) return {};
  const std::string members = type.substr(begin + 1, end - begin - 1);
  if (absl::StrContains(members, "->")) return {};
  return absl::StrSplit(members, ',');
}

std::string BashCompletion(const CLI::App& app) {
  return absl::StrCat("# Completion of ", app.get_name(), " for bash.\n", Function(app),
                      Register(app));
}

std::string ZshCompletion(const CLI::App& app) {
  return absl::StrCat("#compdef ", app.get_name(), "\nautoload -Uz bashcompinit && bashcompinit\n",
                      Function(app), Register(app),
                      // The file's first call must complete, too.
                      "_bash_complete -o default -F ", FunctionName(app), "\n");
}

}  // namespace corbslam::services
