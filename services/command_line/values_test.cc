#include "services/command_line/values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "services/command_line/command_line.h"
#include "services/command_line/setting.h"
#include "services/testing/test_path.h"

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr NamedValues<int, 2> kModes = {{{"none", 0}, {"all", 1}}};

// A program with an option of each kind, one of them of a command.
struct ValuedProgram {
  ValuedProgram() {
    app.add_option("--name", name);
    MayBeEmpty(app.add_option("--note", note));
    app.add_option("--count", count);
    app.add_option("--limit", limit);
    AddSettings(app, {{"--seconds", &seconds, "", {.in = {0, 10}}},
                      {"--kbps", &kbps, "", {.unit = "KBPS"}},
                      {"--strict", &strict, ""},
                      {"--budget", &budget, "", {.in = Bytes(1024, uint64_t{1} << 40, "no bound")}},
                      {"--mode", OneOf(kModes, &mode), ""}});
    app.add_subcommand("go")->add_option("--far", far)->check(CLI::Range(1, 100));
  }

  // Returns what was wrong; empty if nothing.
  std::string Parse(std::vector<const char*> arguments) {
    CommandLine command_line(&app, "map_store");
    arguments.insert(arguments.begin(), "map_store");
    try {
      command_line.Parse(static_cast<int>(arguments.size()), arguments.data());
      return "";
    } catch (const CLI::ParseError& error) {
      return error.what();
    }
  }

  CLI::App app;
  std::string name = "unset";
  std::string note = "unset";
  int count = 1;
  std::optional<uint64_t> limit;
  double seconds = 1;
  uint64_t kbps = 1;
  bool strict = false;
  uint64_t budget = 0;
  int mode = 0;
  int far = 1;
};

std::string ParseOne(const char* flag, const char* value) {
  return ValuedProgram().Parse({flag, value});
}

TEST(ValuesTest, NumbersWithoutASignAreNotNegativeNorRoundTheCorner) {
  for (const char* flag : {"--count", "--limit", "--seconds", "--kbps"}) {
    for (const char* wrong : {"-1", "nan", "inf", "5x", " 5", "5 ", "0x10", "1e999", "+", ""}) {
      EXPECT_THAT(ParseOne(flag, wrong), HasSubstr(std::string(flag) + ": is")) << wrong;
    }
  }
  for (const char* flag : {"--count", "--limit", "--kbps"}) {
    for (const char* wrong : {"1.5", "1e3", "99999999999999999999"}) {
      EXPECT_THAT(ParseOne(flag, wrong), HasSubstr(flag)) << wrong;
    }
  }
  EXPECT_THAT(ParseOne("--count", "4294967296"), HasSubstr("--count"));
  EXPECT_THAT(ParseOne("--seconds", "99999999999999999999"), HasSubstr("--seconds"));
}

TEST(ValuesTest, DigitsAreDecimal) {
  ValuedProgram program;
  EXPECT_EQ(program.Parse({"--count", "010", "--kbps", "0020", "--limit", "08"}), "");
  EXPECT_EQ(program.count, 10);
  EXPECT_EQ(program.kbps, 20u);
  EXPECT_EQ(program.limit, 8u);
}

TEST(ValuesTest, NothingIsEmptyThatDoesNotSaySo) {
  EXPECT_THAT(ParseOne("--name", ""), HasSubstr("--name: is empty: was a variable not set?"));
  ValuedProgram program;
  EXPECT_EQ(program.Parse({"--note", ""}), "");
  EXPECT_EQ(program.note, "");
}

TEST(ValuesTest, SwitchesAreTrueOrFalse) {
  EXPECT_NE(ParseOne("--strict=maybe", "--count"), "");
  EXPECT_NE(ValuedProgram().Parse({"--strict=1abc"}), "");
  ValuedProgram program;
  EXPECT_EQ(program.Parse({"--strict=true"}), "");
  EXPECT_TRUE(program.strict);
}

TEST(ValuesTest, BytesHaveUnitsAndFractions) {
  const auto read = [](const char* text) {
    ValuedProgram program;
    EXPECT_EQ(program.Parse({"--budget", text}), "") << text;
    return program.budget;
  };
  EXPECT_EQ(read("0.5GB"), uint64_t{512} << 20);
  EXPECT_EQ(read("500 MiB"), uint64_t{500} << 20);
  EXPECT_EQ(read("4096"), 4096u);
  EXPECT_EQ(read("64k"), uint64_t{64} << 10);
  EXPECT_EQ(read("0"), 0u);
  for (const char* wrong : {"-1", "1QB", "GB", "1e3", "nan", "1 2", "1MBs", ""}) {
    EXPECT_THAT(ParseOne("--budget", wrong), HasSubstr("--budget: is")) << wrong;
  }
  EXPECT_THAT(ParseOne("--budget", "512"), HasSubstr("must be 1 KiB to 1 TiB, or 0 for no bound"));
  EXPECT_THAT(ParseOne("--budget", "99999999999999999999"), HasSubstr("must be 1 KiB to 1 TiB"));
}

TEST(ValuesTest, ChoicesAreListedRephrased) {
  EXPECT_THAT(ParseOne("--mode", "some"), HasSubstr("is \"some\", must be one of none, all"));
  EXPECT_NE(ParseOne("--mode", "1"), "");
  ValuedProgram program;
  EXPECT_EQ(program.Parse({"--mode", "all"}), "");
  EXPECT_EQ(program.mode, 1);
}

TEST(ValuesTest, RangesAreSaidRephrased) {
  EXPECT_EQ(ParseOne("--seconds", "10.5"), "--seconds: is \"10.5\", must be 0 to 10");
  EXPECT_EQ(Rephrased("--format: json not in {tum,kitti}"),
            "--format: is \"json\", must be one of tum,kitti");
  EXPECT_EQ(Rephrased("anything else"), "anything else");
}

TEST(ValuesTest, CommandsOptionsAreHeldToItToo) {
  EXPECT_THAT(ValuedProgram().Parse({"go", "--far", "-1"}), HasSubstr("--far: is \"-1\""));
}

TEST(ValuesTest, TheEnvironmentAndTheFileAreHeldToItToo) {
  setenv("CORBSLAM_MAP_STORE_LIMIT", "-1", 1);
  EXPECT_THAT(ValuedProgram().Parse({}), AllOf(HasSubstr("--limit"), HasSubstr("MAP_STORE_LIMIT")));
  setenv("CORBSLAM_MAP_STORE_STRICT", "maybe", 1);
  setenv("CORBSLAM_MAP_STORE_LIMIT", "1", 1);
  EXPECT_NE(ValuedProgram().Parse({}), "");
  unsetenv("CORBSLAM_MAP_STORE_STRICT");
  unsetenv("CORBSLAM_MAP_STORE_LIMIT");
  const std::string path = TestPath("values.toml");
  for (const char* line : {"limit = -1", "limit = 99999999999999999999", "seconds = nan",
                           "name = \"\"", "strict = \"maybe\"", "seconds = 1e30"}) {
    std::ofstream(path) << line << "\n";
    EXPECT_NE(ValuedProgram().Parse({"--config", path.c_str()}), "") << line;
  }
}

}  // namespace
}  // namespace corbslam::services
