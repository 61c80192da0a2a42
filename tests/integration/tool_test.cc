// Tests what the tool says where nobody watches, and what it refuses before anything starts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "absl/time/clock.h"
#include "services/runtime/child_process.h"
#include "services/testing/test_path.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using services::ChildProcess;
using services::TestPath;

namespace {

using ::nlohmann::json;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::Not;
using ::testing::StartsWith;

// Nobody listens there: it is reserved for tcpmux, which nobody runs.
constexpr char kNobody[] = "127.0.0.1:1";

// Returns what `program` says when it fails, as it must, within `limit`.
std::string Complaint(const std::string& program, std::vector<std::string> command,
                      absl::Duration limit, int exit_code = 1) {
  command.insert(command.begin(), absl::StrCat(CORBSLAM_PROGRAMS_DIR, "/", program));
  const auto process =
      ChildProcess::Start(program, command, ::testing::TempDir() + "/corbslam_complaint.txt");
  EXPECT_TRUE(process.ok()) << process.status();
  if (!process.ok()) return "";
  EXPECT_TRUE((*process)->WaitForEnd(limit)) << "still runs";
  EXPECT_EQ((*process)->Stop(absl::ZeroDuration()).exit_code, exit_code);
  return std::string((*process)->EndStatus().message());
}

TEST(ToolTest, RefusesBadArgumentsBeforeAnythingStarts) {
  struct {
    std::string program;
    std::vector<std::string> arguments;
    std::string complaint;
  } const cases[] = {
      {"corbslam", {"run", "--mission", "a b/c"}, "--mission is \"a b/c\""},
      {"corbslam", {"run", "--own", "zulu"}, "no robot is called so, but alpha, bravo"},
      {"corbslam", {"run", "--robots", "99"}, "99 robots share 132 frames"},
      {"corbslam", {"run", "--pace", "step", "--server", kNobody}, "leave --server out"},
      {"client_agent", {"--agent", "a b"}, "--agent is \"a b\""},
      {"client_agent", {"--mission", "a b/c"}, "--mission is \"a b/c\""},
  };
  for (const auto& [program, arguments, complaint] : cases) {
    std::vector<std::string> command = arguments;
    command.insert(command.end(), {"--source", DemoSource()});
    // Of the servers and robots these are wrong values, which begin nothing (docs/exit_codes.md).
    const int exit_code = program == "client_agent" ? 2 : 1;
    EXPECT_THAT(Complaint(program, command, absl::Seconds(10), exit_code),
                AllOf(HasSubstr("INVALID_ARGUMENT"), HasSubstr(complaint)));
  }
  EXPECT_THAT(
      Complaint("corbslam", {"render", "--server", kNobody, "--insecure", "--mission", "a b/c"},
                absl::Seconds(10)),
      HasSubstr("--mission is \"a b/c\""));
  // What can't be drawn is refused before anybody is asked.
  for (const auto& [flag, value, complaint] :
       {std::tuple("--out", "map.pdf", "--out map.pdf: the file must end with .svg or .png"),
        {"--out", "-", "--out -: the file must end with"}}) {
    EXPECT_THAT(Complaint("corbslam", {"render", "--server", kNobody, "--insecure", flag, value},
                          absl::Seconds(10)),
                AllOf(HasSubstr("INVALID_ARGUMENT"), HasSubstr(complaint)));
  }
  EXPECT_THAT(Complaint("corbslam", {"render", "--server", kNobody, "--insecure", "--width", "1"},
                        absl::Seconds(10), /*exit_code=*/2),
              HasSubstr("--width: is \"1\", must be 200 to 10000"));
}

TEST(ToolTest, SaysThatATruthIsInMillimetres) {
  const std::string estimate = TestPath("metres.txt");
  const std::string truth = TestPath("millimetres.txt");
  std::ofstream in_metres(estimate);
  std::ofstream in_millimetres(truth);
  for (int i = 0; i < 20; ++i) {
    const double x = 0.1 * i;
    const double y = 0.01 * i * i;
    in_metres << absl::StrFormat("%d %g %g 0 0 0 0 1\n", i, x, y);
    in_millimetres << absl::StrFormat("%d %g %g 0 0 0 0 1\n", i, 1000 * x, 1000 * y);
  }
  in_metres.close();
  in_millimetres.close();
  EXPECT_THAT(RunTool({"eval", "--truth", truth, estimate}),
              HasSubstr("the truth is 1000 times as large as the estimates"));
  EXPECT_THAT(RunTool({"eval", "--truth", estimate, estimate}), Not(HasSubstr("times as large")));
}

// Two recordings of one room, each with a clock that begins at 0, in two robots' fused map.
TEST(ToolTest, HoldsTwoSequencesAgainstTruthsInOneFrame) {
  const auto write = [](const std::string& name, double x) {
    const std::string path = TestPath(name);
    std::ofstream file(path);
    for (int i = 0; i < 20; ++i) {
      file << absl::StrFormat("%d %g %g 0 0 0 0 1\n", i, x + 0.1 * i, 0.01 * i * i);
    }
    return path;
  };
  const std::string first = write("first.txt", 0);
  const std::string second = write("second.txt", 5);
  // The second robot's map lies 0.2 m beside where it should be to the first's.
  const std::string beside = write("beside.txt", 5.2);
  std::vector<std::string> command = {"eval", "--truth", first, "--truth", second, first, beside};
  const std::string own = RunTool(command);
  EXPECT_THAT(own, HasSubstr("no fused error: --truth-frame shared"));
  EXPECT_THAT(own, Not(HasSubstr("\nfused ")));
  command.insert(command.end(), {"--truth-frame", "shared", "--json", "-"});
  const json rows = json::parse(RunTool(command));
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_LT(rows[1]["ate_m"], 1e-6) << "alone the second is right";
  EXPECT_EQ(rows[2]["name"], "fused");
  EXPECT_EQ(rows[2]["poses"], 40);
  EXPECT_GT(rows[2]["ate_m"], 0.05);
}

TEST(ToolTest, SaysThatNoStoreAnswers) {
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"render", "--server", kNobody, "--insecure"},
        {"run", "--server", kNobody, "--insecure", "--source", DemoSource(), "--out",
         ::testing::TempDir() + "/corbslam_dead_store"}}) {
    EXPECT_THAT(Complaint("corbslam", command, absl::Seconds(25)),
                HasSubstr(absl::StrCat("UNAVAILABLE: no map store answers at ", kNobody)));
  }
}

TEST(ToolTest, SaysThatThereIsNoSuchMission) {
  RunningServers servers;
  ASSERT_FALSE(servers.store_address().empty());
  EXPECT_THAT(Complaint("corbslam",
                        {"render", "--server", servers.store_address(), "--insecure", "--mission",
                         "nowhere"},
                        absl::Seconds(10)),
              AllOf(HasSubstr("NOT_FOUND"), HasSubstr("there is no mission nowhere")));
}

// Returns the document on standard output, behind warnings of the log.
json ReadDocument(const std::string& said) { return json::parse(said.substr(said.find('{'))); }

TEST(ToolTest, ForgetsSessionsAndSaysWhatItDoesNotKnow) {
  RunningServers servers;
  ASSERT_FALSE(servers.store_address().empty());
  const auto forget = [&servers](const std::vector<std::string>& more) {
    std::vector<std::string> command = {
        "mission", "forget", "--insecure", "--server", servers.store_address(), "--mission", "lab"};
    command.insert(command.end(), more.begin(), more.end());
    return command;
  };
  const auto complaint = [&forget](const std::vector<std::string>& more, int exit_code = 1) {
    return Complaint("corbslam", forget(more), absl::Seconds(10), exit_code);
  };
  EXPECT_THAT(complaint({"--agent", "alpha", "--keep", "1"}),
              AllOf(HasSubstr("NOT_FOUND"), HasSubstr("there is no mission lab")));
  RunTool({"run", "--server", servers.store_address(), "--insecure", "--source",
           DemoSource() + "?frames=0:19", "--robots", "1", "--mission", "lab", "--pace", "max",
           "--out", ::testing::TempDir() + "/corbslam_tool_forget"});
  EXPECT_THAT(complaint({"--agent", "nobody", "--keep", "1"}),
              AllOf(HasSubstr("NOT_FOUND"), HasSubstr("has no agent nobody")));
  EXPECT_THAT(complaint({"--agent", "alpha"}), HasSubstr("give either --before or --keep"));
  EXPECT_THAT(complaint({"--agent", "alpha", "--before", "1", "--keep", "1"}),
              HasSubstr("give either --before or --keep"));
  EXPECT_THAT(complaint({"--agent", "alpha", "--before", "yesterday"}),
              HasSubstr("--before yesterday"));
  EXPECT_THAT(complaint({"--agent", "alpha", "--keep", "-1"}, 2), HasSubstr("--keep"));
  EXPECT_THAT(complaint({"--keep", "1"}, 2), HasSubstr("--agent"));
  const json would =
      ReadDocument(RunTool(forget({"--agent", "alpha", "--keep", "0", "--dry-run", "--json"})));
  EXPECT_TRUE(would["dry_run"]);
  EXPECT_EQ(would["local_maps"].size(), 1u);
  EXPECT_GT(would["keyframes"], 0);
  EXPECT_THAT(RunTool(forget({"--agent", "alpha", "--keep", "0"})),
              AllOf(HasSubstr("deleted 1 local maps of alpha"), HasSubstr("points: alpha/1\n")));
  const json again = ReadDocument(RunTool(forget({"--agent", "alpha", "--keep", "0", "--json"})));
  EXPECT_EQ(again["local_maps"].size(), 0u) << "nothing is left, and that is no error";
}

// Recognises lines that say what a source is: its name, and what is known of it, indented.
bool IsOfSource(const std::string& line) {
  return absl::StartsWith(line, "  ") || absl::StartsWith(line, "tum:");
}

TEST(ToolTest, SaysWhatItsSourceIsAndInTwoLinesWhatItDoesWhereNobodyWatches) {
  const std::string folder = ::testing::TempDir() + "/corbslam_tool_run";
  const std::string text = RunTool({"run", "--source", DemoSource() + "?frames=0:19", "--robots",
                                    "1", "--pace", "step", "--out", folder});
  EXPECT_THAT(text, AllOf(HasSubstr("alpha map tum:"), HasSubstr("results go to " + folder),
                          HasSubstr(folder + "/report.md"), Not(HasSubstr("\r"))));
  std::vector<std::string> lines = absl::StrSplit(text, '\n', absl::SkipEmpty());
  EXPECT_THAT(lines, Contains(HasSubstr("groundtruth.txt says that it is of rgbd_dataset")));
  EXPECT_EQ(std::erase_if(lines, IsOfSource), 8u) << text;
  // On a slow machine.
  std::erase_if(lines,
                [](const std::string& line) { return absl::StartsWith(line, "progress: "); });
  EXPECT_EQ(lines.size(), 2u) << text;
}

TEST(ToolTest, ShowsWhatItIsGoodFor) {
  const std::string folder = TestPath("demo");
  RunTool({"demo", "--source", DemoSource(), "--out", folder});
  const json report = json::parse(ReadText(folder + "/report.json"));
  ASSERT_EQ(report["robots"].size(), 2u);
  EXPECT_EQ(report["fused"]["islands"], 1);
  EXPECT_LT(report["fused"]["ate_m"], 0.03);
  EXPECT_THAT(ReadText(folder + "/report.md"), HasSubstr("| bravo |"));
  for (const char* picture : {"/map.png", "/alpha.map.png", "/bravo.map.png"}) {
    EXPECT_THAT(ReadText(folder + picture), StartsWith("\x89PNG")) << picture;
  }
  EXPECT_TRUE(report["company"].is_null());
}

// Robots in lockstep see each other's map; alone they are told nothing, and nothing else differs.
TEST(ToolTest, SaysWhatCompanyGave) {
  const std::string folder = TestPath("company");
  RunTool({"run", "--source", DemoSource() + "?frames=0:79", "--robots", "2", "--overlap", "25",
           "--pace", "step", "--company", "--out", folder});
  const json report = json::parse(ReadText(folder + "/report.json"));
  const json& company = report["company"];
  ASSERT_EQ(company["robots"].size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    const json& robot = company["robots"][i];
    EXPECT_EQ(robot["name"], report["robots"][i]["name"]);
    EXPECT_EQ(robot["frames"]["with"], robot["frames"]["without"]);
    EXPECT_EQ(robot["ate_m"]["with"], report["robots"][i]["ate_m"]);
    EXPECT_GT(robot["others"]["keyframes_held"], 0) << robot["name"];
  }
  const json alone = json::parse(ReadText(folder + "/alone/report.json"));
  EXPECT_EQ(alone["mission"], "demo-alone");
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(alone["robots"][i]["shared"]["keyframes_held"], 0);
    EXPECT_EQ(company["robots"][i]["ate_m"]["without"], alone["robots"][i]["ate_m"]);
  }
  EXPECT_THAT(ReadText(folder + "/report.md"), HasSubstr("## What company gave"));
  EXPECT_THAT(ReadText(folder + "/report.html"),
              AllOf(HasSubstr("h-company"), HasSubstr("The map that bravo holds")));
  for (const char* picture : {"/alpha.map.png", "/bravo.map.png", "/alone/alpha.map.png"}) {
    EXPECT_THAT(ReadText(folder + picture), StartsWith("\x89PNG")) << picture;
  }
}

TEST(ToolTest, FindsNothingWrongWithWhatWorks) {
  RunningServers servers;
  ASSERT_FALSE(servers.store_address().empty());
  // The log's warning of --insecure comes first.
  const std::string said = RunTool({"doctor", "--insecure", "--server", servers.store_address(),
                                    "--source", DemoSource(), "--json"});
  const json findings = json::parse(said.substr(std::min(said.find("[\n"), said.size())));
  std::set<std::string> checks;
  for (const json& finding : findings) {
    EXPECT_NE(finding["level"], "fail") << finding;
    checks.insert(finding["check"]);
  }
  EXPECT_THAT(checks,
              IsSupersetOf({std::string("clock"), std::string("source"), std::string("vocabulary"),
                            "store " + servers.store_address()}));
}

TEST(ToolTest, SaysWhatIsWrongWithWhatDoesNot) {
  EXPECT_THAT(
      Complaint("corbslam", {"doctor", "--insecure", "--server", kNobody}, absl::Seconds(30)),
      HasSubstr(kNobody));
}

TEST(ToolTest, TrainsAVocabularyInSilenceWhereNobodyWatches) {
  const std::string text = RunTool({"vocabulary", "train", DemoSource().substr(4) + "/rgb",
                                    "--features", "100", "--branching", "4", "--levels", "2",
                                    "--out", ::testing::TempDir() + "/corbslam_tool.voc"});
  EXPECT_THAT(text, Not(HasSubstr("\r")));
}

}  // namespace
}  // namespace corbslam::tests
