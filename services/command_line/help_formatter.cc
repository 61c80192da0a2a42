#include "services/command_line/help_formatter.h"

#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"

namespace corbslam::services {
namespace {

constexpr size_t kLineLength = 100;

std::vector<std::string> BreakIntoLines(const std::string& text, size_t length) {
  std::vector<std::string> lines(1);
  for (const absl::string_view word : absl::StrSplit(text, ' ', absl::SkipEmpty())) {
    if (!lines.back().empty() && lines.back().size() + 1 + word.size() > length) {
      lines.emplace_back();
    }
    absl::StrAppend(&lines.back(), lines.back().empty() ? "" : " ", word);
  }
  return lines;
}

}  // namespace

std::string ValueName(const CLI::Option& option) {
  if (option.get_type_size() == 0) return "";
  const std::string name = option.get_type_name();
  // CLI::IsMember describes itself as "TEXT:{se3,sim3}".
  const size_t begin = name.find('{');
  if (begin != std::string::npos) {
    return absl::StrReplaceAll(name.substr(begin + 1, name.find('}') - begin - 1), {{",", "|"}});
  }
  // The limits stand behind a colon; the error of a wrong value names them.
  return name.substr(0, name.find(':'));
}

std::string DefaultNote(const CLI::Option& option) {
  if (option.get_type_size() == 0 || option.get_default_str().empty()) return "";
  return absl::StrCat(" [", option.get_default_str(), "]");
}

std::string HelpFormatter::TwoColumns(const std::string& left, const std::string& right) const {
  const size_t width = column_width_;
  std::string text = absl::StrCat("  ", left);
  // If the left text is too long, the right column begins on the next line.
  text += text.size() + 2 > width ? "\n" + std::string(width, ' ')
                                  : std::string(width - text.size(), ' ');
  const std::vector<std::string> lines = BreakIntoLines(right, kLineLength - width);
  for (size_t i = 0; i < lines.size(); ++i) {
    if (i > 0) text += std::string(width, ' ');
    absl::StrAppend(&text, lines[i], "\n");
  }
  return text;
}

std::string HelpFormatter::make_option(const CLI::Option* option, bool is_positional) const {
  std::string left = is_positional ? option->get_name(true) : option->get_name(false, true);
  const std::string value = is_positional ? "" : ValueName(*option);
  if (!value.empty()) absl::StrAppend(&left, " ", value);
  if (option->get_expected_max() == CLI::detail::expected_max_vector_size) left += "...";
  const bool must = option->get_required() && option->get_configurable();
  return TwoColumns(left, absl::StrCat(must ? "Required. " : "", option->get_description(),
                                       DefaultNote(*option)));
}

std::string HelpFormatter::make_subcommand(const CLI::App* command) const {
  return TwoColumns(command->get_name(), command->get_description());
}

std::string HelpFormatter::MakeGroups(const CLI::App& app, CLI::AppFormatMode mode) const {
  std::string text;
  for (const std::string& group : app.get_groups()) {
    if (group.empty() || (group == kRareGroup && mode != CLI::AppFormatMode::All)) continue;
    const std::vector<const CLI::Option*> options = app.get_options([&](const CLI::Option* option) {
      return option->get_group() == group && option->nonpositional();
    });
    if (!options.empty()) text += make_group(group, /*is_positional=*/false, options);
  }
  return text;
}

std::string HelpFormatter::make_help(const CLI::App* app, std::string name,
                                     CLI::AppFormatMode mode) const {
  if (mode == CLI::AppFormatMode::Sub) return make_expanded(app);
  return absl::StrCat(app->get_description(), "\n", make_usage(app, std::move(name)),
                      make_positionals(app), MakeGroups(*app, mode), make_subcommands(app, mode),
                      make_footer(app));
}

}  // namespace corbslam::services
