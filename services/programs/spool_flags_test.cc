#include "services/programs/spool_flags.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

SpoolFlags ParseSpool(const std::vector<std::string>& arguments) {
  SpoolFlags flags;
  CLI::App app;
  AddSpoolFlags(app, flags);
  app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  return flags;
}

std::string WhatIsWrong(const std::vector<std::string>& arguments, bool has_server) {
  return std::string(CheckSpoolFlags(ParseSpool(arguments), has_server).message());
}

TEST(SpoolFlagsTest, TheFolderHasTwoNames) {
  EXPECT_EQ(ParseSpool({"--spool", "a"}).folder, "a");
  EXPECT_EQ(ParseSpool({"--spool-dir", "a"}).folder, "a");
}

TEST(SpoolFlagsTest, WhatIsMappedIsOnTheDiskWithinASecondUnlessSaidOtherwise) {
  client_agent::AgentOptions options;
  ApplySpoolFlags(ParseSpool({}), options);
  EXPECT_EQ(options.spool_within, absl::ZeroDuration());
  ApplySpoolFlags(ParseSpool({"--spool", "a"}), options);
  EXPECT_EQ(options.spool_within, absl::Seconds(1));
  EXPECT_FALSE(options.resume);
  ApplySpoolFlags(ParseSpool({"--spool", "a", "--resume", "--resume-wait-s", "3"}), options);
  EXPECT_TRUE(options.resume);
  EXPECT_EQ(options.resume_wait, absl::Seconds(3));
}

TEST(SpoolFlagsTest, WhatDoesNotGoTogetherIsSaid) {
  EXPECT_EQ(WhatIsWrong({}, false), "");
  EXPECT_EQ(WhatIsWrong({"--spool", "a"}, false), "");
  EXPECT_EQ(WhatIsWrong({"--spool", "a", "--spool-sync-s", "0"}, true), "");
  EXPECT_THAT(WhatIsWrong({"--resume"}, true), HasSubstr("--resume needs --spool"));
  EXPECT_THAT(WhatIsWrong({"--spool", "a", "--resume", "--spool-sync-s", "0"}, true),
              HasSubstr("--spool-sync-s is 0"));
  EXPECT_THAT(WhatIsWrong({"--spool", "a", "--spool-sync-s", "0"}, false),
              HasSubstr("--spool without --server"));
}

}  // namespace
}  // namespace corbslam::services
