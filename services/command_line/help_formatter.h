// Formats what --help prints: a line a flag where it fits, 100 columns, defaults in brackets.
#ifndef CORBSLAM_SERVICES_COMMAND_LINE_HELP_FORMATTER_H_
#define CORBSLAM_SERVICES_COMMAND_LINE_HELP_FORMATTER_H_

#include <CLI/CLI.hpp>
#include <string>

namespace corbslam::services {

// Flags of this group are in --help-all only.
inline constexpr char kRareGroup[] = "Limits";

// Returns what an option takes, such as "HOST" or "on|off", where it is one of a few; "" for a
// flag.
std::string ValueName(const CLI::Option& option);
// Returns the option's default in brackets behind a space, or "" if it has none worth a word.
std::string DefaultNote(const CLI::Option& option);

class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter() { column_width(28); }

  std::string make_subcommand(const CLI::App* command) const override;
  std::string make_option(const CLI::Option* option, bool is_positional) const override;
  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override;

 private:
  std::string MakeGroups(const CLI::App& app, CLI::AppFormatMode mode) const;
  // Returns two columns; the right one is broken into lines.
  std::string TwoColumns(const std::string& left, const std::string& right) const;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_COMMAND_LINE_HELP_FORMATTER_H_
