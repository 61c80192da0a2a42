#include "services/command_line/advice.h"

#include <algorithm>
#include <cstddef>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "services/command_line/help_formatter.h"

namespace corbslam::services {
namespace {

// Returns how many letters must be changed, added, taken out, or exchanged with the next one
// (Damerau 1964, in the restricted form).
size_t CountEdits(absl::string_view a, absl::string_view b) {
  std::vector<std::vector<size_t>> edits(a.size() + 1, std::vector<size_t>(b.size() + 1));
  for (size_t i = 0; i <= a.size(); ++i) {
    for (size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        edits[i][j] = i + j;
        continue;
      }
      const size_t changed = edits[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      edits[i][j] = std::min({changed, edits[i - 1][j] + 1, edits[i][j - 1] + 1});
      const bool exchanged = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (exchanged) edits[i][j] = std::min(edits[i][j], edits[i - 2][j - 2] + 1);
    }
  }
  return edits[a.size()][b.size()];
}

// Returns the last of the commands that were typed rightly.
const CLI::App& FindInnermost(const CLI::App& app) {
  const std::vector<CLI::App*> parsed = app.get_subcommands();
  return parsed.empty() ? app : FindInnermost(*parsed.front());
}

std::string FullName(const CLI::App& app) {
  const CLI::App* parent = app.get_parent();
  return parent == nullptr ? app.get_name() : absl::StrCat(FullName(*parent), " ", app.get_name());
}

std::vector<const CLI::App*> ListCommands(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* command) { return !command->get_name().empty(); });
}

std::string ListInColumns(const CLI::App& app) {
  std::string text;
  for (const CLI::App* command : ListCommands(app)) {
    absl::StrAppend(&text, HelpFormatter().make_subcommand(command));
  }
  return text;
}

std::string Suggest(absl::string_view typed, const std::vector<std::string>& known) {
  const std::string nearest = FindNearest(typed, known);
  return nearest.empty() ? "" : absl::StrCat("; did you mean \"", nearest, "\"?");
}

std::string FirstThatIsNoFlag(const std::vector<std::string>& known) {
  for (const std::string& word : known) {
    if (!absl::StartsWith(word, "-")) return word;
  }
  return "";
}

}  // namespace

std::string FindNearest(absl::string_view typed, const std::vector<std::string>& known) {
  std::string nearest;
  size_t least = 0;
  for (const std::string& word : known) {
    const size_t edits = CountEdits(typed, word);
    if (3 * edits > std::max<size_t>(word.size(), 3)) continue;
    if (!nearest.empty() && edits >= least) continue;
    least = edits;
    nearest = word;
  }
  return nearest;
}

std::string DescribeWrongCommand(const CLI::App& app) {
  const CLI::App& innermost = FindInnermost(app);
  std::vector<std::string> names;
  for (const CLI::App* command : ListCommands(innermost)) names.push_back(command->get_name());
  if (names.empty()) return "";
  const std::string typed = FirstThatIsNoFlag(innermost.remaining());
  if (!typed.empty()) {
    return absl::StrCat(FullName(innermost), " has no command \"", typed, "\"",
                        Suggest(typed, names), "\nIts commands:\n", ListInColumns(innermost));
  }
  if (!innermost.remaining().empty()) return "";
  return absl::StrCat(FullName(innermost), " wants one of its commands:\n",
                      ListInColumns(innermost), "Each tells more with --help.\n");
}

std::string DescribeWrongFlag(const CLI::App& app) {
  const CLI::App& innermost = FindInnermost(app);
  std::vector<std::string> names;
  for (const CLI::App* at = &innermost; at != nullptr; at = at->get_parent()) {
    for (const CLI::Option* option : at->get_options()) {
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
  }
  for (const std::string& word : app.remaining(/*recurse=*/true)) {
    const std::string flag = word.substr(0, word.find('='));
    if (!absl::StartsWith(flag, "--")) continue;
    return absl::StrCat(FullName(innermost), " has no flag ", flag, Suggest(flag, names), "\n");
  }
  return "";
}

}  // namespace corbslam::services
