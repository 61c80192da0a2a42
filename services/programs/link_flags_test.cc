#include "services/programs/link_flags.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// Returns what is wrong with the arguments; empty if nothing.
std::string Parse(std::vector<std::string> arguments, LinkFlags& flags) {
  CLI::App app;
  AddLinkFlags(app, flags);
  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::Error& error) {
    return error.what();
  }
  return "";
}

TEST(LinkFlagsTest, AreThousandsOfBits) {
  LinkFlags flags;
  EXPECT_EQ(Parse({"--uplink-kbps", "256", "--downlink-kbps=1000"}, flags), "");
  EXPECT_EQ(BytesPerSecond(flags.uplink_kbps), 32000u);
  EXPECT_EQ(BytesPerSecond(flags.downlink_kbps), 125000u);
}

TEST(LinkFlagsTest, TakeTheLimitsAndNoBound) {
  for (const char* value : {"0", "8", "10000000"}) {
    LinkFlags flags;
    EXPECT_EQ(Parse({"--uplink-kbps", value}, flags), "") << value;
    EXPECT_EQ(flags.uplink_kbps, std::stoull(value));
  }
}

TEST(LinkFlagsTest, RefuseTheRestByNameValueAndLimits) {
  for (const char* value :
       {"7", "1", "10000001", "-1", "-256", "256k", "1e3", "12.5", "nan", "18446744073709551616"}) {
    LinkFlags flags;
    EXPECT_THAT(Parse({std::string("--uplink-kbps=") + value}, flags),
                AllOf(HasSubstr("--uplink-kbps"), HasSubstr(value), HasSubstr("8 to 10000000")))
        << value;
  }
}

TEST(LinkFlagsTest, NeedAStore) {
  EXPECT_TRUE(CheckNoLinkFlags({}).ok());
  EXPECT_THAT(CheckNoLinkFlags({.uplink_kbps = 256}).message(),
              HasSubstr("--uplink-kbps needs --server"));
  EXPECT_THAT(CheckNoLinkFlags({.downlink_kbps = 256}).message(),
              HasSubstr("--downlink-kbps needs --server"));
}

}  // namespace
}  // namespace corbslam::services
