#include "services/command_line/command_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <memory>
#include <vector>

#include "services/testing/test_path.h"

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// Sets an environment variable for as long as it lives.
class Variable {
 public:
  Variable(const std::string& name, const std::string& value) : name_(name) {
    setenv(name.c_str(), value.c_str(), 1);
  }
  ~Variable() { unsetenv(name_.c_str()); }

 private:
  const std::string name_;
};

// A program with a flag of each kind, and without commands.
struct Program {
  Program() {
    app.add_option("--listen", listen)->capture_default_str();
    app.add_option("--worker", workers)->delimiter(',');
    app.add_option("--threads", threads)->check(CLI::Range(1, 8))->capture_default_str();
    app.add_option("--threads-per-worker", per_worker)->capture_default_str();
    app.add_flag("--insecure", insecure);
  }

  // Returns what was wrong; empty if nothing.
  std::string Parse(std::vector<const char*> arguments) {
    command_line = std::make_unique<CommandLine>(&app, "map_store");
    arguments.insert(arguments.begin(), "map_store");
    try {
      command_line->Parse(static_cast<int>(arguments.size()), arguments.data());
      return "";
    } catch (const CLI::ParseError& error) {
      return error.what();
    }
  }

  CLI::App app;
  std::unique_ptr<CommandLine> command_line;
  std::string listen = "default:1";
  std::vector<std::string> workers;
  int threads = 2;
  int per_worker = 3;
  bool insecure = false;
};

std::string WriteConfig(const std::string& text) {
  const std::string path = TestPath("flags.toml");
  std::ofstream(path) << text;
  return path;
}

TEST(CommandLineTest, FlagsCountBeforeEnvironmentBeforeFileBeforeDefaults) {
  const std::string path = WriteConfig("listen = \"file:1\"\n");
  {
    Program program;
    EXPECT_EQ(program.Parse({}), "");
    EXPECT_EQ(program.listen, "default:1");
  }
  {
    Program program;
    EXPECT_EQ(program.Parse({"--config", path.c_str()}), "");
    EXPECT_EQ(program.listen, "file:1");
  }
  const Variable listen("CORBSLAM_MAP_STORE_LISTEN", "environment:1");
  {
    Program program;
    EXPECT_EQ(program.Parse({"--config", path.c_str()}), "");
    EXPECT_EQ(program.listen, "environment:1");
  }
  Program program;
  EXPECT_EQ(program.Parse({"--config", path.c_str(), "--listen", "flag:1"}), "");
  EXPECT_EQ(program.listen, "flag:1");
}

TEST(CommandLineTest, TakesEveryKindOfValueFromEnvironmentAndFile) {
  const Variable workers("CORBSLAM_MAP_STORE_WORKER", "a:1,b:2");
  const Variable insecure("CORBSLAM_MAP_STORE_INSECURE", "true");
  const std::string path = WriteConfig("threads = 4\nworker = [\"c:3\"]\n");
  const Variable config("CORBSLAM_MAP_STORE_CONFIG", path);
  Program program;
  EXPECT_EQ(program.Parse({}), "");
  EXPECT_EQ(program.workers, (std::vector<std::string>{"a:1", "b:2"}));
  EXPECT_TRUE(program.insecure);
  EXPECT_EQ(program.threads, 4);
  Program other;
  const std::string list = WriteConfig("worker = [\"c:3\", \"d:4\"]\ninsecure = true\n");
  unsetenv("CORBSLAM_MAP_STORE_WORKER");
  unsetenv("CORBSLAM_MAP_STORE_INSECURE");
  EXPECT_EQ(other.Parse({"--config", list.c_str()}), "");
  EXPECT_EQ(other.workers, (std::vector<std::string>{"c:3", "d:4"}));
  EXPECT_TRUE(other.insecure);
}

TEST(CommandLineTest, RefusesUnknownKeysByFileLineAndName) {
  const std::string path = WriteConfig("threads = 4\n\n# lisen\nlisen = \"a:1\"\n");
  Program program;
  EXPECT_EQ(program.Parse({"--config", path.c_str()}),
            path + ":4: \"lisen\" is no flag of this program");
  Program other;
  EXPECT_THAT(other.Parse({"--lisen", "a:1"}), HasSubstr("--lisen"));
  // The key "help" is no setting, but names what may be done once.
  const std::string help = WriteConfig("help = true\n");
  Program third;
  EXPECT_EQ(third.Parse({"--config", help.c_str()}),
            help + ":1: \"help\" is no flag of this program");
}

TEST(CommandLineTest, RefusesUnknownVariablesButThoseOfKubernetes) {
  const Variable host("CORBSLAM_MAP_STORE_SERVICE_HOST", "10.0.0.1");
  const Variable port("CORBSLAM_MAP_STORE_PORT_50051_TCP", "tcp://10.0.0.1:50051");
  const Variable tests("CORBSLAM_DATA_DIR", "/recordings");
  {
    Program program;
    EXPECT_EQ(program.Parse({}), "");
  }
  const Variable typo("CORBSLAM_MAP_STORE_LISTN", "a:1");
  Program program;
  EXPECT_EQ(program.Parse({}),
            "the environment variable CORBSLAM_MAP_STORE_LISTN means no flag of this program");
}

TEST(CommandLineTest, SaysWhereAWrongValueStands) {
  const std::string path = WriteConfig("listen = \"a:1\"\nthreads = 99\n");
  Program program;
  EXPECT_THAT(program.Parse({"--config", path.c_str()}),
              AllOf(HasSubstr("--threads"), HasSubstr("99"), HasSubstr("(" + path + ":2)")));
  const Variable threads("CORBSLAM_MAP_STORE_THREADS", "many");
  Program other;
  EXPECT_THAT(other.Parse({}), AllOf(HasSubstr("many"), HasSubstr("(CORBSLAM_MAP_STORE_THREADS)")));
}

TEST(CommandLineTest, RefusesAFileThatIsNotThere) {
  Program program;
  EXPECT_THAT(program.Parse({"--config", "/nowhere/map_store.toml"}),
              HasSubstr("/nowhere/map_store.toml"));
  const Variable config("CORBSLAM_MAP_STORE_CONFIG", "/nowhere/else.toml");
  Program other;
  EXPECT_THAT(other.Parse({}), HasSubstr("/nowhere/else.toml"));
}

TEST(CommandLineTest, DescribesTheConfigurationAsAFileThatSaysTheSame) {
  const Variable listen("CORBSLAM_MAP_STORE_LISTEN", "environment:1");
  const std::string path = WriteConfig("threads = 4\n");
  Program program;
  EXPECT_EQ(program.Parse({"--config", path.c_str(), "--worker", "a:1", "--worker", "b:2"}), "");
  const std::string text = program.command_line->DescribeConfiguration();
  EXPECT_EQ(text,
            "listen=\"environment:1\"  # CORBSLAM_MAP_STORE_LISTEN\n"
            "worker=[\"a:1\", \"b:2\"]  # command line\n"
            "threads=4  # " +
                path +
                ":1\n"
                "threads-per-worker=3\n"
                "insecure=false\n");
  unsetenv("CORBSLAM_MAP_STORE_LISTEN");
  const std::string again = WriteConfig(text);
  Program other;
  EXPECT_EQ(other.Parse({"--config", again.c_str()}), "");
  EXPECT_EQ(other.listen, "environment:1");
  EXPECT_EQ(other.workers, (std::vector<std::string>{"a:1", "b:2"}));
  EXPECT_EQ(other.threads, 4);
  EXPECT_FALSE(other.insecure);
}

TEST(CommandLineTest, DescribesWhatHasNoValueAndHidesSecrets) {
  Program program;
  EXPECT_EQ(program.Parse({"--listen", "rtsp://eve:pa55@camera"}), "");
  const std::string text = program.command_line->DescribeConfiguration();
  EXPECT_THAT(text, HasSubstr("# worker is not set\n"));
  EXPECT_THAT(text, AllOf(HasSubstr("rtsp://eve:***@camera"), Not(HasSubstr("pa55"))));
}

// A program with "tool list --server ..." and "tool delete --server ... --mission ...".
struct Tool {
  Tool() {
    app.require_subcommand(1);
    for (const char* name : {"list", "delete"}) {
      CLI::App* command = app.add_subcommand(name);
      command->add_option("--server", servers[name])->required();
      if (std::string(name) == "delete") command->add_option("--mission", mission);
    }
  }

  std::string Parse(std::vector<const char*> arguments) {
    CommandLine command_line(&app, "tool");
    arguments.insert(arguments.begin(), "tool");
    try {
      command_line.Parse(static_cast<int>(arguments.size()), arguments.data());
      return "";
    } catch (const CLI::ParseError& error) {
      return error.what();
    }
  }

  CLI::App app;
  std::map<std::string, std::string> servers;
  std::string mission;
};

TEST(CommandLineTest, CommandsTakeWhatStandsAboveAndInTheirSection) {
  const std::string path =
      WriteConfig("server = \"all:1\"\nmission = \"lab\"\n\n[delete]\nserver = \"delete:1\"\n");
  Tool list;
  EXPECT_EQ(list.Parse({"--config", path.c_str(), "list"}), "");
  EXPECT_EQ(list.servers["list"], "all:1");
  Tool remove;
  EXPECT_EQ(remove.Parse({"--config", path.c_str(), "delete", "--server", "flag:1"}), "");
  EXPECT_EQ(remove.servers["delete"], "flag:1");
  EXPECT_EQ(remove.mission, "lab");
  // A section does not run its command.
  Tool none;
  EXPECT_THAT(none.Parse({"--config", path.c_str()}), HasSubstr("subcommand"));
}

TEST(CommandLineTest, RefusesUnknownKeysOfCommands) {
  const std::string path = WriteConfig("[delete]\nserver = \"a:1\"\nmision = \"lab\"\n");
  Tool tool;
  EXPECT_EQ(tool.Parse({"--config", path.c_str(), "list", "--server", "b:1"}),
            path + ":3: \"delete.mision\" is no flag of this program");
  const std::string section = WriteConfig("[remove]\nserver = \"a:1\"\n");
  Tool other;
  EXPECT_EQ(other.Parse({"--config", section.c_str(), "list", "--server", "b:1"}),
            section + ":2: \"remove.server\" is no flag of this program");
}

TEST(CommandLineTest, CommandsTakeEnvironment) {
  const Variable server("CORBSLAM_TOOL_SERVER", "environment:1");
  Tool tool;
  EXPECT_EQ(tool.Parse({"list"}), "");
  EXPECT_EQ(tool.servers["list"], "environment:1");
}

}  // namespace
}  // namespace corbslam::services
