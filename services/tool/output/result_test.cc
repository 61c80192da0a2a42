#include "services/tool/output/result.h"

#include <gtest/gtest.h>

#include <vector>

namespace corbslam::services {
namespace {

// A tool with "mission list", which has a --json of its own, "mission delete", and "eval --json
// FILE".
struct Tool {
  Tool() {
    CLI::App* mission = app.add_subcommand("mission");
    mission->add_subcommand("list")->add_flag("--json", own);
    mission->add_subcommand("delete");
    app.add_subcommand("eval")->add_option("--json", file);
    AddJsonFlags(app);
  }

  bool Asks(std::vector<const char*> arguments) {
    arguments.insert(arguments.begin(), "corbslam");
    app.parse(static_cast<int>(arguments.size()), arguments.data());
    return AsksForJson(app);
  }

  CLI::App app;
  bool own = false;
  std::string file;
};

TEST(ResultTest, EveryCommandTakesJson) {
  EXPECT_TRUE(Tool().Asks({"mission", "list", "--json"}));
  EXPECT_TRUE(Tool().Asks({"mission", "delete", "--json"}));
  EXPECT_FALSE(Tool().Asks({"mission", "delete"}));
  EXPECT_FALSE(Tool().Asks({"mission", "list"}));
  EXPECT_THROW(Tool().Asks({"--json", "mission", "list"}), CLI::ParseError);
}

TEST(ResultTest, AFileForJsonIsNoWishForIt) {
  EXPECT_FALSE(Tool().Asks({"eval", "--json", "table.json"}));
  EXPECT_TRUE(Tool().Asks({"eval", "--json", "-"}));
}

TEST(ResultTest, ArgumentsThatAreWrongAreLookedAtToo) {
  const char* const wrong[] = {"corbslam", "misson", "--json"};
  EXPECT_TRUE(AsksForJson(3, wrong));
  EXPECT_FALSE(AsksForJson(2, wrong));
}

TEST(ResultTest, AnErrorHasItsCodeAndItsMessage) {
  EXPECT_EQ(ErrorToJson(absl::NotFoundError("there is no mission \"x\"")).dump(),
            R"({"error":{"code":"NOT_FOUND","message":"there is no mission \"x\""}})");
}

}  // namespace
}  // namespace corbslam::services
