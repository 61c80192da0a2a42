#include "services/command_line/man_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "absl/strings/str_cat.h"
#include "services/command_line/command_line.h"
#include "services/testing/test_path.h"

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

struct Program {
  Program() : app("Does things", "program") {
    app.add_option("--listen", text, "HOST:PORT, as 'here' or .there")->default_str("a:1");
    app.add_option("--vocabulary", text, "File")->default_str("/tmp/build/a.voc");
    app.add_option("--hidden", text, "Nobody's business")->group("");
    CLI::App* command = app.add_subcommand("command", ".starts with a dot");
    command->add_option("file", text, "A\\B")->required();
    command_line = std::make_unique<CommandLine>(&app, "program");
  }

  CLI::App app;
  std::string text;
  std::unique_ptr<CommandLine> command_line;
};

TEST(ManPageTest, HasEveryFlagButTheHiddenOnes) {
  const Program program;
  EXPECT_THAT(FormatManPage(program.app, "CORBSLAM_PROGRAM_", "1.2"),
              AllOf(HasSubstr(".TH PROGRAM 1 \"\" \"corbslam 1.2\" \"CORB\\-SLAM\"\n"),
                    HasSubstr("\\fB\\-\\-listen\\fR \\fITEXT\\fR\nHOST:PORT, as 'here' or .there "
                              "[a:1]\n"),
                    HasSubstr(".SS program command\n\\&.starts with a dot.\n"),
                    HasSubstr("\\fIfile\\fR\nRequired. A\\eB\n"), Not(HasSubstr("/tmp/build")),
                    Not(HasSubstr("hidden")), Not(HasSubstr("man\\-page"))));
}

TEST(ManPageTest, IsRenderedWithoutWarnings) {
  if (std::system("command -v man >/dev/null") != 0) {
    ASSERT_EQ(std::getenv("CI"), nullptr) << "there is no man";
    GTEST_SKIP() << "there is no man (deploy/packages_checks.txt)";
  }
  const Program program;
  const std::string page = TestPath("page.1");
  std::ofstream(page) << FormatManPage(program.app, "CORBSLAM_PROGRAM_", "1.2");
  FILE* pipe = popen(
      absl::StrCat("LC_ALL=C.UTF-8 MANWIDTH=80 man --warnings -l ", page, " 2>&1").c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string shown;
  for (int c = fgetc(pipe); c != EOF; c = fgetc(pipe)) shown.push_back(static_cast<char>(c));
  EXPECT_EQ(pclose(pipe), 0);
  EXPECT_THAT(shown, AllOf(HasSubstr("--listen TEXT"), HasSubstr("CORBSLAM_PROGRAM_FLAG"),
                           HasSubstr("CORBSLAM_VOCABULARY"), HasSubstr("CORBSLAM_VIEWER_PAGE"),
                           HasSubstr(".starts with a dot."), Not(HasSubstr("warning"))));
}

}  // namespace
}  // namespace corbslam::services
