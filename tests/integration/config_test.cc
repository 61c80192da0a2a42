// Tests how the programs are configured: what they print of it, refuse and log.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "services/runtime/child_process.h"
#include "services/security/testing/test_certificates.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using services::ChildProcess;

namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

struct Ended {
  int exit_code = -1;
  std::string text;
};

std::string TempFile(const std::string& name) {
  return ::testing::TempDir() + "/corbslam_config_test_" + name;
}

std::string WriteConfig(const std::string& text) {
  const std::string path = TempFile("config.toml");
  std::ofstream(path) << text;
  return path;
}

Ended RunToEnd(const std::string& program, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), absl::StrCat(CORBSLAM_PROGRAMS_DIR, "/", program));
  const std::string log = TempFile("output.txt");
  const auto process = ChildProcess::Start(program, arguments, log);
  EXPECT_TRUE(process.ok()) << process.status();
  if (!process.ok()) return {};
  EXPECT_TRUE((*process)->WaitForEnd(absl::Seconds(60))) << "still runs";
  const int exit_code = (*process)->Stop(absl::ZeroDuration()).exit_code;
  return {exit_code, ReadText(log)};
}

TEST(ConfigTest, HelpFitsAScreen) {
  for (const char* program : {"map_store", "fusion_worker", "client_agent", "corbslam"}) {
    const Ended help = RunToEnd(program, {"--help"});
    EXPECT_EQ(help.exit_code, 0) << program;
    const auto lines = std::count(help.text.begin(), help.text.end(), '\n');
    EXPECT_GE(lines, 20) << program;
    EXPECT_LE(lines, 50) << program;
  }
  EXPECT_THAT(RunToEnd("map_store", {"--help"}).text, Not(HasSubstr("--max-parked")));
  EXPECT_THAT(RunToEnd("map_store", {"--help-all"}).text, HasSubstr("--max-parked"));
}

struct Flag {
  std::vector<std::string> command;  // Words of the tool's command that it is of.
  std::string name;
  std::string type;
};

// Returns the flags that take a value, as the program's manual page lists them.
std::vector<Flag> ListFlags(const std::string& program) {
  const std::string page =
      absl::StrReplaceAll(RunToEnd(program, {"--man-page"}).text, {{"\\-", "-"}});
  std::vector<Flag> flags;
  std::vector<std::string> command;
  for (const absl::string_view line : absl::StrSplit(page, '\n')) {
    if (absl::StartsWith(line, ".SS ")) {
      command = absl::StrSplit(line.substr(4), ' ');
      command.erase(command.begin());  // The program's own name.
    }
    if (absl::StartsWith(line, ".SH ENVIRONMENT")) break;
    if (!absl::StartsWith(line, "\\fB--")) continue;
    const std::vector<std::string> words = absl::StrSplit(line, ' ');
    if (!absl::StartsWith(words.back(), "\\fI")) continue;
    const std::string name = words[0].substr(3, words[0].find_first_of(",\\", 3) - 3);
    flags.push_back({command, name, words.back().substr(3, words.back().find('\\', 3) - 3)});
  }
  return flags;
}

void ExpectRefused(const std::string& program, const Flag& flag, const std::string& value) {
  std::vector<std::string> arguments = flag.command;
  arguments.insert(arguments.end(), {flag.name, value});
  const Ended ended = RunToEnd(program, arguments);
  const std::string said =
      absl::StrCat(program, " ", absl::StrJoin(arguments, " "), "\n", ended.text);
  EXPECT_EQ(ended.exit_code, 2) << said;
  EXPECT_THAT(ended.text, HasSubstr(flag.name)) << said;
}

constexpr const char* kPrograms[] = {"map_store", "fusion_worker", "client_agent", "map_viewer",
                                     "corbslam"};

bool IsOfNumber(const Flag& flag) {
  const std::set<std::string> numbers = {"UINT",   "INT",   "FLOAT", "KBPS",
                                         "METRES", "BYTES", "NUMBER"};
  return numbers.contains(flag.type);
}

TEST(ConfigTest, ManualPagesSayWhichFlagsTakeNumbers) {
  int64_t of_numbers = 0;
  for (const char* program : kPrograms) {
    of_numbers += std::ranges::count_if(ListFlags(program), IsOfNumber);
  }
  EXPECT_GT(of_numbers, 80);
}

class EveryFlagTest : public ::testing::TestWithParam<const char*> {};

// What a shell makes of a variable that is not set, and what is no number of anything.
TEST_P(EveryFlagTest, TakesNoNumberThatIsNone) {
  const std::vector<Flag> flags = ListFlags(GetParam());
  EXPECT_GT(flags.size(), 10u);
  for (const Flag& flag : flags) {
    std::vector<std::string> values = {""};
    if (IsOfNumber(flag)) values = {"", "-1", "1e30", "nan", "99999999999999999999", "7x"};
    // An empty description takes the old one back.
    if (flag.name == "--description") continue;
    for (const std::string& value : values) ExpectRefused(GetParam(), flag, value);
  }
}

INSTANTIATE_TEST_SUITE_P(Programs, EveryFlagTest, ::testing::ValuesIn(kPrograms),
                         [](const auto& program) { return std::string(program.param); });

TEST(ConfigTest, EveryProgramHasTheSameVersion) {
  const Ended tool = RunToEnd("corbslam", {"--version"});
  EXPECT_EQ(tool.exit_code, 0);
  for (const char* program : {"map_store", "fusion_worker", "client_agent"}) {
    EXPECT_EQ(RunToEnd(program, {"--version"}).text, tool.text) << program;
  }
}

TEST(ConfigTest, ValidConfigurationsEndWithZeroAndStartNothing) {
  const std::string folder = TempFile("missions");
  std::filesystem::remove_all(folder);
  const Ended store = RunToEnd("map_store", {"--validate-config", "--insecure", "--data-dir",
                                             folder, "--in-process-worker"});
  EXPECT_EQ(store.exit_code, 0) << store.text;
  EXPECT_THAT(store.text, AllOf(HasSubstr("map_store: the configuration is valid"),
                                Not(HasSubstr("listening"))));
  EXPECT_FALSE(std::filesystem::exists(folder));
  EXPECT_EQ(RunToEnd("fusion_worker", {"--validate-config", "--insecure"}).exit_code, 0);
  const Ended agent = RunToEnd("client_agent", {"--validate-config", "--insecure", "--source",
                                                DemoSource(), "--server", "127.0.0.1:1"});
  EXPECT_EQ(agent.exit_code, 0) << agent.text;
}

TEST(ConfigTest, InvalidConfigurationsEndWithTwoAndSayAllThatIsWrong) {
  const Ended store = RunToEnd(
      "map_store", {"--validate-config", "--listen", "nowhere", "--worker", "a:b", "--vocabulary",
                    "/none.voc", "--data-dir", "/dev/null/missions", "--max-missions", "0"});
  EXPECT_EQ(store.exit_code, 2);
  EXPECT_THAT(store.text, AllOf(HasSubstr("map_store: --listen: address is \"nowhere\""),
                                HasSubstr("map_store: --worker: address is \"a:b\""),
                                HasSubstr("/none.voc"), HasSubstr("/dev/null is no folder"),
                                HasSubstr("max_missions"), HasSubstr("--tls-cert")));
  const Ended agent =
      RunToEnd("client_agent", {"--validate-config", "--source", "tum:/nowhere", "--agent", "a b",
                                "--spool-dir", TempFile("spool"), "--spool-sync-s", "0", "--stats",
                                "/nowhere/stats.json", "--memory-budget", "90MB"});
  EXPECT_EQ(agent.exit_code, 2);
  EXPECT_THAT(agent.text,
              AllOf(HasSubstr("/nowhere: there is no such folder"), HasSubstr("--agent is \"a b\""),
                    HasSubstr("--spool without --server"), HasSubstr("/nowhere/stats.json"),
                    HasSubstr("--memory-budget is ")));
  // This can't even be parsed.
  const Ended flag = RunToEnd("fusion_worker", {"--validate-config", "--threads", "none"});
  EXPECT_EQ(flag.exit_code, 2);
  EXPECT_THAT(flag.text, HasSubstr("--threads"));
}

TEST(ConfigTest, LocalizeNeedsOneCamera) {
  const std::vector<std::string> asks = {"localize",  "--server", "127.0.0.1:1",
                                         "--mission", "m",        "hall.png"};
  const auto ask = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = asks;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunToEnd("corbslam", arguments);
  };
  const Ended none = ask({});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.text, AllOf(HasSubstr("--rig FILE"), HasSubstr("--camera \"FX FY CX CY\""),
                               Not(HasSubstr("Option Group"))));
  const Ended json = ask({"--json"});
  EXPECT_EQ(json.exit_code, 2);
  EXPECT_THAT(json.text, AllOf(HasSubstr("INVALID_ARGUMENT"), HasSubstr("--rig FILE")));
  const Ended both = ask({"--rig", "rig.yaml", "--camera", "1 2 3 4"});
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_THAT(both.text, HasSubstr("give one of them"));
  const Ended words = ask({"--camera", "500 500 300"});
  EXPECT_EQ(words.exit_code, 2);
  EXPECT_THAT(words.text, HasSubstr("must have 4 numbers"));
}

TEST(ConfigTest, FilesThatFlagsNameAreLookedInto) {
  const test_data::TestCertificates certificates("lab");
  std::vector<std::string> flags = certificates.Flags("store");
  flags.push_back("--validate-config");
  EXPECT_EQ(RunToEnd("fusion_worker", flags).exit_code, 0);
  std::filesystem::copy_file(certificates.Path("alpha.key"), certificates.Path("store.key"),
                             std::filesystem::copy_options::overwrite_existing);
  const Ended mixed = RunToEnd("fusion_worker", flags);
  EXPECT_EQ(mixed.exit_code, 2);
  EXPECT_THAT(mixed.text, HasSubstr("does not belong to"));
}

TEST(ConfigTest, UnknownKeysAreRefusedByFileAndLine) {
  const std::string path = WriteConfig("insecure = true\nlisen = \"127.0.0.1:0\"\n");
  const Ended store = RunToEnd("map_store", {"--config", path});
  EXPECT_NE(store.exit_code, 0);
  EXPECT_THAT(store.text, HasSubstr(path + ":2: \"lisen\" is no flag of this program"));
  setenv("CORBSLAM_MAP_STORE_LISEN", "127.0.0.1:0", 1);
  const Ended variable = RunToEnd("map_store", {"--validate-config"});
  unsetenv("CORBSLAM_MAP_STORE_LISEN");
  EXPECT_EQ(variable.exit_code, 2);
  EXPECT_THAT(variable.text, HasSubstr("CORBSLAM_MAP_STORE_LISEN means no flag"));
}

// Starts a worker, and returns what it logged until it was stopped.
std::string LogOfWorker(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), absl::StrCat(CORBSLAM_PROGRAMS_DIR, "/fusion_worker"));
  const std::string log = TempFile("worker.txt");
  const auto worker = ChildProcess::Start("fusion_worker", arguments, log);
  EXPECT_TRUE(worker.ok()) << worker.status();
  if (!worker.ok()) return "";
  const auto address = (*worker)->WaitForAddress(absl::Seconds(60));
  EXPECT_TRUE(address.ok()) << address.status();
  EXPECT_EQ((*worker)->Stop(absl::Seconds(20)).exit_code, 0);
  return ReadText(log);
}

TEST(ConfigTest, SettingsArePrintedWithTheirSourcesAndNothingIsStarted) {
  const std::string path = WriteConfig("threads = 3\nrequests = 7\n");
  setenv("CORBSLAM_FUSION_WORKER_REQUESTS", "5", 1);
  const Ended printed = RunToEnd("fusion_worker", {"--print-config", "--config", path, "--insecure",
                                                   "--listen", "127.0.0.1:0"});
  unsetenv("CORBSLAM_FUSION_WORKER_REQUESTS");
  EXPECT_EQ(printed.exit_code, 0);
  EXPECT_THAT(printed.text,
              AllOf(HasSubstr("threads=3  # " + path + ":1\n"),
                    HasSubstr("requests=5  # CORBSLAM_FUSION_WORKER_REQUESTS\n"),
                    HasSubstr("listen=\"127.0.0.1:0\"  # command line\n"), HasSubstr("\ndrain=2\n"),
                    HasSubstr("# tls-key is not set\n"), Not(HasSubstr("listening on"))));
}

TEST(ConfigTest, TheLogBeginsWithWhatItIsAndHasNoSettings) {
  const std::string log = LogOfWorker({"--insecure", "--listen", "127.0.0.1:0"});
  EXPECT_THAT(log, ContainsRegex("\\] fusion_worker [0-9.]+\n"));
  EXPECT_THAT(log,
              ContainsRegex("\\] serves 127.0.0.1:[0-9]+ without TLS, to everybody; works on 2 "
                            "requests at once, holds 16\n"));
  EXPECT_THAT(log, Not(HasSubstr("drain")));
  EXPECT_LE(std::count(log.begin(), log.end(), '\n'), 6) << log;
}

TEST(ConfigTest, SecretsAreNeitherLoggedNorPrinted) {
  const test_data::TestCertificates certificates("lab");
  std::vector<std::string> flags = certificates.Flags("worker");
  flags.insert(flags.end(), {"--listen", "127.0.0.1:0"});
  std::string text = LogOfWorker(flags);
  flags.push_back("--print-config");
  text += RunToEnd("fusion_worker", flags).text;
  EXPECT_THAT(text, HasSubstr(certificates.Path("worker.key")));
  const std::string key = ReadText(certificates.Path("worker.key"));
  for (size_t begin = 0; begin + 64 < key.size(); begin = key.find('\n', begin) + 1) {
    const std::string line = key.substr(begin, key.find('\n', begin) - begin);
    EXPECT_THAT(text, Not(HasSubstr(line)));
  }
}

TEST(ConfigTest, WrongFlagsEndWithTwo) {
  for (const char* program : {"map_store", "fusion_worker", "map_viewer", "client_agent"}) {
    EXPECT_EQ(RunToEnd(program, {"--no-such-flag"}).exit_code, 2) << program;
  }
  EXPECT_EQ(RunToEnd("corbslam", {"misson"}).exit_code, 2);
  EXPECT_EQ(RunToEnd("corbslam", {"mission", "list"}).exit_code, 2) << "--server is missing";
  EXPECT_EQ(RunToEnd("corbslam", {}).exit_code, 2);
}

TEST(ConfigTest, ErrorsAreJsonWhereResultsAre) {
  const Ended failed =
      RunToEnd("corbslam", {"journal", "check", "--data-dir", "/nowhere/missions", "--json"});
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_THAT(failed.text, AllOf(StartsWith("{\"error\":{\"code\":\""),
                                 HasSubstr("/nowhere/missions"), EndsWith("}}\n")));
  const Ended wrong = RunToEnd("corbslam", {"mission", "list", "--json"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.text, AllOf(StartsWith("{\"error\":{\"code\":\"INVALID_ARGUMENT\""),
                                HasSubstr("--server"), EndsWith("}}\n")));
}

}  // namespace
}  // namespace corbslam::tests
