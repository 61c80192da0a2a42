#include "services/command_line/man_page.h"

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "services/command_line/help_formatter.h"

namespace corbslam::services {
namespace {

// Escapes the text so that troff takes it for nothing else.
std::string Escape(const std::string& text) {
  const std::string escaped = absl::StrReplaceAll(text, {{"\\", "\\e"}, {"-", "\\-"}});
  const bool looks_like_a_request = absl::StartsWith(text, ".") || absl::StartsWith(text, "'");
  return looks_like_a_request ? "\\&" + escaped : escaped;
}

std::string Bold(const std::string& text) { return "\\fB" + Escape(text) + "\\fR"; }
std::string Italic(const std::string& text) { return "\\fI" + Escape(text) + "\\fR"; }

std::string Note(const CLI::Option& option) {
  return absl::StartsWith(option.get_default_str(), "/") ? "" : DefaultNote(option);
}

std::string FormatOption(const CLI::Option& option) {
  std::string text = ".TP\n";
  if (option.get_positional()) {
    text += Italic(option.get_name(true));
  } else {
    text += Bold(absl::StrReplaceAll(option.get_name(false, true), {{",", ", "}}));
    if (!ValueName(option).empty()) text += " " + Italic(ValueName(option));
  }
  const bool must = option.get_required() && option.get_configurable();
  return absl::StrCat(text, "\n", must ? "Required. " : "",
                      Escape(option.get_description() + Note(option)), "\n");
}

std::string FormatOptions(const CLI::App& app) {
  std::string text;
  for (const CLI::Option* option : app.get_options()) {
    if (!option->get_group().empty()) text += FormatOption(*option);
  }
  return text;
}

// Returns the commands below, each under the command line that calls it.
std::string FormatCommands(const CLI::App& app, const std::string& path) {
  std::string text;
  for (const CLI::App* command : app.get_subcommands({})) {
    if (command->get_group().empty()) continue;
    const std::string call = absl::StrCat(path, " ", command->get_name());
    absl::StrAppend(&text, ".SS ", Escape(call), "\n", Escape(command->get_description()), ".\n",
                    FormatOptions(*command), FormatCommands(*command, call));
  }
  return text;
}

std::string Section(const std::string& title, const std::string& text) {
  return text.empty() ? "" : absl::StrCat(".SH ", title, "\n", text);
}

}  // namespace

std::string FormatManPage(const CLI::App& app, const std::string& environment_prefix,
                          const std::string& version) {
  const std::string name = app.get_name();
  return absl::StrCat(
      ".TH ", absl::AsciiStrToUpper(name), " 1 \"\" \"corbslam ", version, "\" \"CORB\\-SLAM\"\n",
      Section("NAME", absl::StrCat(Escape(name), " \\- ", Escape(app.get_description()), "\n")),
      Section("SYNOPSIS",
              absl::StrCat(Bold(name), app.get_subcommands({}).empty() ? "" : " \\fICOMMAND\\fR",
                           " [\\fIOPTION\\fR...]\n")),
      Section("OPTIONS", FormatOptions(app)), Section("COMMANDS", FormatCommands(app, name)),
      Section("ENVIRONMENT",
              absl::StrCat(".TP\n", Bold(environment_prefix), Italic("FLAG"),
                           "\nThe value of the flag, in capitals and with underscores. A flag on "
                           "the command line\ncounts before it; it counts before the file of ",
                           Bold("--config"), ", and that before the default.\n.TP\n",
                           Bold("CORBSLAM_VOCABULARY"), "\nThe vocabulary, unless ",
                           Bold("--vocabulary"), " names one.\n.TP\n", Bold("CORBSLAM_VIEWER_PAGE"),
                           "\nThe folder of the viewer's built page, of map_viewer, unless ",
                           Bold("--page"), " names one, and\nof the reports of corbslam.\n")),
      Section("FILES", absl::StrCat(".TP\n", Italic("../share/corbslam/corbslam.voc"),
                                    "\nThe vocabulary, seen from the program's folder.\n.TP\n",
                                    Italic("../share/corbslam/viewer"),
                                    "\nThe viewer's built page, likewise.\n")),
      Section("SEE ALSO",
              "corbslam(1), map_store(1), fusion_worker(1), map_viewer(1), client_agent(1), "
              "simulated_agent(1)\n"));
}

}  // namespace corbslam::services
