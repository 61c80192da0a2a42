#include "services/command_line/completion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "services/command_line/command_line.h"
#include "services/testing/test_path.h"

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;

struct Tool {
  Tool() : app("A tool", "tool") {
    CLI::App* list = app.add_subcommand("list", "Lists");
    list->add_option("--server", text, "Where");
    CLI::App* mission = app.add_subcommand("mission", "Missions");
    CLI::App* save = mission->add_subcommand("save", "Saves");
    save->add_option("--format", text, "How")->check(CLI::IsMember({"ply", "tum"}));
    save->add_option("--pace", text, "How fast")->type_name("max|sensor");
    mission->add_subcommand("secret", "Nobody's business")->group("");
    command_line = std::make_unique<CommandLine>(&app, "tool");
  }

  CLI::App app;
  std::string text;
  std::unique_ptr<CommandLine> command_line;
};

std::string RunShell(const std::string& command) {
  std::string output;
  FILE* pipe = popen(command.c_str(), "r");
  EXPECT_NE(pipe, nullptr);
  for (int c = fgetc(pipe); c != EOF; c = fgetc(pipe)) output.push_back(static_cast<char>(c));
  EXPECT_EQ(pclose(pipe), 0);
  return output;
}

// Returns what a real bash offers for the words, the last of which is being typed.
std::vector<std::string> Complete(const std::vector<std::string>& words) {
  Tool tool;
  const std::string script = TestPath("completion.bash");
  std::ofstream(script) << BashCompletion(tool.app);
  const std::string output = RunShell(absl::StrCat(
      "bash -c 'source ", script, "; COMP_WORDS=(\"", absl::StrJoin(words, "\" \""),
      "\"); COMP_CWORD=", words.size() - 1,
      "; _corbslam_complete_tool; printf \"%s\\n\" \"${COMPREPLY[@]}\"; complete -p tool'"));
  std::vector<std::string> lines = absl::StrSplit(output, '\n', absl::SkipEmpty());
  EXPECT_EQ(lines.back(), "complete -o default -F _corbslam_complete_tool tool");
  lines.pop_back();
  return lines;
}

// Returns what a real zsh chooses from for the words; it leaves out itself what does not begin like
// the last one.
std::vector<std::string> CompleteInZsh(const std::vector<std::string>& words) {
  Tool tool;
  const std::string script = TestPath("completion.zsh");
  // The script's last line completes, which zsh allows where Tab was hit and nowhere else. The
  // options are those in which its bashcompinit calls functions.
  std::ofstream(script) << "autoload -Uz compinit; compinit -D\n"
                        << ZshCompletion(tool.app) << R"(
offer() {
  emulate -L sh
  setopt kshglob noshglob braceexpand ksharrays
  COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
  _corbslam_complete_tool
  printf '%s\n' "${COMPREPLY[@]}"
}
)"
                        << "offer \"" << absl::StrJoin(words, "\" \"") << "\"\n";
  return absl::StrSplit(RunShell(absl::StrCat("zsh -f ", script, " 2>/dev/null </dev/null")), '\n',
                        absl::SkipEmpty());
}

TEST(CompletionTest, OffersCommandsAndFlags) {
  EXPECT_THAT(Complete({"tool", ""}),
              AllOf(Contains("list"), Contains("mission"), Contains("--version")));
  EXPECT_THAT(Complete({"tool", "mi"}), ElementsAre("mission"));
  EXPECT_THAT(Complete({"tool", "mission", "s"}), ElementsAre("save"));
  EXPECT_THAT(Complete({"tool", "list", "--s"}), ElementsAre("--server"));
  EXPECT_THAT(Complete({"tool", "list", "--"}), Not(Contains("--format")));
}

TEST(CompletionTest, OffersValuesWhereThereAreFew) {
  EXPECT_THAT(Complete({"tool", "mission", "save", "--format", ""}), ElementsAre("ply", "tum"));
  EXPECT_THAT(Complete({"tool", "mission", "save", "--pace", "s"}), ElementsAre("sensor"));
  // Names of files come from -o default.
  EXPECT_THAT(Complete({"tool", "list", "--server", ""}), IsEmpty());
}

TEST(CompletionTest, FollowsCommandsBehindFlagsAndValues) {
  EXPECT_THAT(Complete({"tool", "--config", "file", "mission", "save", "--fo"}),
              ElementsAre("--format"));
}

TEST(CompletionTest, IsTheSameInZsh) {
  if (std::system("command -v zsh >/dev/null") != 0) {
    ASSERT_EQ(std::getenv("CI"), nullptr) << "there is no zsh";
    GTEST_SKIP() << "there is no zsh";
  }
  EXPECT_THAT(CompleteInZsh({"tool", "mi"}),
              AllOf(Contains("list"), Contains("mission"), Contains("--version")));
  EXPECT_THAT(CompleteInZsh({"tool", "mission", "s"}),
              AllOf(Contains("save"), Not(Contains("list"))));
  EXPECT_THAT(CompleteInZsh({"tool", "mission", "save", "--format", ""}),
              ElementsAre("ply", "tum"));
}

TEST(CompletionTest, IsPrintedByThePrograms) {
  Tool tool;
  const char* const arguments[] = {"tool", "--completion", "zsh"};
  try {
    tool.command_line->Parse(3, arguments);
    ADD_FAILURE() << "nothing was thrown";
  } catch (const CLI::Success& success) {
    EXPECT_EQ(std::string(success.what()), ZshCompletion(tool.app));
  }
}

}  // namespace
}  // namespace corbslam::services
