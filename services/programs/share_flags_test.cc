#include "services/programs/share_flags.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// Returns what is wrong with the arguments; empty if nothing.
std::string Parse(std::vector<std::string> arguments, ShareFlags& flags) {
  CLI::App app;
  AddShareFlags(app, flags);
  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::Error& error) {
    return error.what();
  }
  return "";
}

TEST(ShareFlagsTest, EverythingWithoutThem) {
  ShareFlags flags;
  EXPECT_EQ(Parse({}, flags), "");
  EXPECT_EQ(ScopeOf(flags), ShareScope());
  EXPECT_TRUE(CheckShareFlags(flags, /*has_server=*/false).ok());
}

TEST(ShareFlagsTest, AreWhatTheStoreIsAskedFor) {
  const std::vector<std::pair<std::string, ShareMode>> modes = {
      {"none", ShareMode::kNone},
      {"corrections", ShareMode::kCorrections},
      {"nearby", ShareMode::kNearby},
      {"everything", ShareMode::kEverything}};
  for (const auto& [name, mode] : modes) {
    ShareFlags flags;
    EXPECT_EQ(Parse({"--share", name}, flags), "");
    EXPECT_EQ(ScopeOf(flags).mode, mode) << name;
    EXPECT_EQ(ScopeOf(flags).radius_m, 50) << name;
    EXPECT_TRUE(CheckShareFlags(flags, /*has_server=*/true).ok()) << name;
  }
  ShareFlags flags;
  EXPECT_EQ(Parse({"--share=nearby", "--share-radius=12.5"}, flags), "");
  EXPECT_EQ(ScopeOf(flags), (ShareScope{ShareMode::kNearby, 12.5}));
  EXPECT_TRUE(CheckShareFlags(flags, /*has_server=*/true).ok());
}

TEST(ShareFlagsTest, RefuseTheRestByNameAndValue) {
  ShareFlags flags;
  EXPECT_THAT(Parse({"--share", "half"}, flags), AllOf(HasSubstr("--share"), HasSubstr("half")));
  for (const char* value : {"0", "0.9", "-5", "1000001", "nan", "inf", "near"}) {
    EXPECT_THAT(Parse({std::string("--share-radius=") + value}, flags),
                AllOf(HasSubstr("--share-radius"), HasSubstr(value), HasSubstr("1 to 1e+06")))
        << value;
  }
}

TEST(ShareFlagsTest, NeedAStoreAndEachOther) {
  ShareFlags flags;
  ASSERT_EQ(Parse({"--share", "none"}, flags), "");
  EXPECT_THAT(CheckShareFlags(flags, /*has_server=*/false).message(),
              HasSubstr("--share needs --server"));
  ShareFlags lone;
  ASSERT_EQ(Parse({"--share-radius", "7"}, lone), "");
  EXPECT_THAT(CheckShareFlags(lone, /*has_server=*/true).message(),
              AllOf(HasSubstr("--share-radius is 7"), HasSubstr("--share nearby")));
}

}  // namespace
}  // namespace corbslam::services
