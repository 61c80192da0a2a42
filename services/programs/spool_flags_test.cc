#include "services/programs/spool_flags.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace corbslam::services {
namespace {

namespace fs = std::filesystem;
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

// Spools of every format, as programs of their time left them (tests/data/golden/README.md): their
// batches are the wire's messages of then.
TEST(SpoolFlagsTest, WhatOlderRobotsLeftIsRead) {
  const fs::path golden = CORBSLAM_GOLDEN_DATA;
  std::ifstream expected(golden / "expected_spools.txt");
  std::string line;
  int read = 0;
  while (std::getline(expected, line)) {
    if (line.empty() || line.front() == '#') continue;
    SCOPED_TRACE(line);
    std::istringstream fields(line);
    SpoolFlags flags;
    std::string name;
    size_t records = 0;
    size_t keyframes = 0;
    ASSERT_TRUE(fields >> name >> records >> keyframes);
    flags.folder = (fs::path(::testing::TempDir()) / name).string();
    fs::remove_all(flags.folder);
    fs::copy(golden / name, flags.folder, fs::copy_options::recursive);
    const auto spool = OpenSpool(flags, "missions/golden/agents/alpha");
    ASSERT_TRUE(spool.ok()) << spool.status();
    std::set<KeyframeId> found;
    for (const client_agent::SpooledBatch& spooled : (*spool)->found()) {
      const auto batch = (*spool)->Read(spooled);
      ASSERT_TRUE(batch.ok()) << batch.status();
      for (const FullKeyframe& keyframe : batch->full_keyframes) found.insert(keyframe.payload->id);
    }
    EXPECT_EQ((*spool)->found().size(), records);
    EXPECT_EQ(found.size(), keyframes);
    ++read;
  }
  EXPECT_GE(read, 1);
}

}  // namespace
}  // namespace corbslam::services
