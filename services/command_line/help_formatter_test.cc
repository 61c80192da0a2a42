#include "services/command_line/help_formatter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "absl/strings/str_split.h"
#include "services/command_line/command_line.h"

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

struct Program {
  Program() : app("Does things") {
    app.add_option("--listen", listen, "HOST:PORT to serve on")->capture_default_str();
    app.add_option("--threads", threads, "Threads")->check(CLI::Range(1, 8))->capture_default_str();
    app.add_option("--max-things", things, "Things at most")->group(kRareGroup);
    app.add_option("--long", text, std::string(40, 'a') + " " + std::string(40, 'b'))->required();
    app.add_option("--hidden", text, "Nobody's business")->group("");
    command_line = std::make_unique<CommandLine>(&app, "program");
  }

  CLI::App app;
  std::unique_ptr<CommandLine> command_line;
  std::string listen = "127.0.0.1:1";
  std::string text;
  int threads = 2;
  int things = 0;
};

TEST(HelpFormatterTest, PrintsALineAFlagWithItsDefault) {
  const Program program;
  const std::string help = program.app.help();
  EXPECT_THAT(help,
              AllOf(HasSubstr("  --listen TEXT             HOST:PORT to serve on [127.0.0.1:1]\n"),
                    HasSubstr("  --threads INT             Threads [2]\n"),
                    HasSubstr("  --version                 Print the version and exit\n"),
                    HasSubstr("CORBSLAM_PROGRAM_FLAG for --flag")));
  for (const absl::string_view line : absl::StrSplit(help, '\n')) EXPECT_LE(line.size(), 100);
}

TEST(HelpFormatterTest, LeavesLimitsToHelpAll) {
  const Program program;
  EXPECT_THAT(program.app.help(), Not(HasSubstr("--max-things")));
  EXPECT_THAT(program.app.help("", CLI::AppFormatMode::All), HasSubstr("--max-things"));
  EXPECT_THAT(program.app.help("", CLI::AppFormatMode::All), Not(HasSubstr("--hidden")));
}

TEST(HelpFormatterTest, BreaksLongDescriptions) {
  const Program program;
  EXPECT_THAT(program.app.help(),
              HasSubstr("  --long TEXT               Required. " + std::string(40, 'a') + "\n" +
                        std::string(28, ' ') + std::string(40, 'b') + "\n"));
}

}  // namespace
}  // namespace corbslam::services
