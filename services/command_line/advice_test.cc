#include "services/command_line/advice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "services/command_line/command_line.h"

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

TEST(FindNearestTest, TakesTheFewestEditsAndNoneThatIsFar) {
  const std::vector<std::string> known = {"mission", "run", "render", "demo", "doctor"};
  EXPECT_EQ(FindNearest("mision", known), "mission");
  EXPECT_EQ(FindNearest("rnu", known), "run");
  EXPECT_EQ(FindNearest("doctr", known), "doctor");
  EXPECT_EQ(FindNearest("rendre", known), "render");
  EXPECT_EQ(FindNearest("launch", known), "");
  EXPECT_EQ(FindNearest("", known), "");
  EXPECT_EQ(FindNearest("x", {}), "");
}

// A program like the tool: it has commands, one of which has commands of its own.
struct Tool {
  Tool() {
    app.require_subcommand(1);
    app.add_subcommand("run", "Robots into one map")->add_option("--server", server, "Where");
    CLI::App* mission = app.add_subcommand("mission", "What is there");
    mission->require_subcommand(1);
    mission->add_subcommand("list", "All of them");
    mission->add_subcommand("show", "One of them");
  }
  // Returns what is printed on standard error, and the exit code.
  std::string Parse(std::vector<const char*> arguments) {
    CommandLine command_line(&app, "tool");
    arguments.insert(arguments.begin(), "corbslam");
    ::testing::internal::CaptureStderr();
    exit_code = command_line.ParseOrExit(static_cast<int>(arguments.size()), arguments.data());
    return ::testing::internal::GetCapturedStderr();
  }

  CLI::App app{"Several robots, one map", "corbslam"};
  std::string server;
  std::optional<int> exit_code;
};

TEST(AdviceTest, WithoutACommandAllAreListed) {
  Tool tool;
  EXPECT_THAT(tool.Parse({}),
              AllOf(StartsWith("corbslam wants one of its commands"), HasSubstr("run "),
                    HasSubstr("What is there"), Not(HasSubstr("All of them"))));
  EXPECT_EQ(tool.exit_code, kWrongUsage);
}

TEST(AdviceTest, WithinACommandItsOwnAreListed) {
  EXPECT_THAT(Tool().Parse({"mission"}),
              AllOf(StartsWith("corbslam mission wants one of its commands"),
                    HasSubstr("All of them"), Not(HasSubstr("Robots into one map"))));
}

TEST(AdviceTest, AMistypedCommandIsNamedWithTheOneThatWasMeant) {
  Tool tool;
  EXPECT_THAT(tool.Parse({"mision", "list"}),
              AllOf(StartsWith("corbslam has no command \"mision\"; did you mean \"mission\"?"),
                    HasSubstr("Its commands"), HasSubstr("run ")));
  EXPECT_EQ(tool.exit_code, kWrongUsage);
  EXPECT_THAT(Tool().Parse({"mission", "lits"}),
              StartsWith("corbslam mission has no command \"lits\"; did you mean \"list\"?"));
  EXPECT_THAT(Tool().Parse({"launch"}), AllOf(StartsWith("corbslam has no command \"launch\"\n"),
                                              HasSubstr("Robots into one map")));
}

TEST(AdviceTest, AMistypedFlagIsNamedWithTheOneThatWasMeant) {
  EXPECT_EQ(Tool().Parse({"run", "--sever=x"}),
            "corbslam run has no flag --sever; did you mean \"--server\"?\n");
  EXPECT_EQ(Tool().Parse({"run", "--quite-another"}), "corbslam run has no flag --quite-another\n");
}

TEST(AdviceTest, NothingIsSaidOfWhatIsRight) {
  Tool tool;
  EXPECT_THAT(tool.Parse({"run", "--server", "here"}), IsEmpty());
  EXPECT_EQ(tool.exit_code, std::nullopt);
  EXPECT_EQ(tool.server, "here");
}

}  // namespace
}  // namespace corbslam::services
