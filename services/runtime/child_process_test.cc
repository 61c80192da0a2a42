#include "services/runtime/child_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

std::string LogPath(const std::string& name) { return ::testing::TempDir() + "child_" + name; }

absl::StatusOr<std::unique_ptr<ChildProcess>> RunShell(const std::string& name,
                                                       const std::string& script) {
  return ChildProcess::Start(name, {"/bin/sh", "-c", script}, LogPath(name));
}

TEST(ChildProcessTest, ReadsTheAddressAndStops) {
  const auto child =
      RunShell("server", "echo hello; echo listening on 127.0.0.1:123; exec sleep 100");
  ASSERT_TRUE(child.ok()) << child.status();
  const absl::StatusOr<std::string> address = (*child)->WaitForAddress(absl::Seconds(10));
  ASSERT_TRUE(address.ok()) << address.status();
  EXPECT_EQ(*address, "127.0.0.1:123");
  EXPECT_FALSE((*child)->end().has_value());
}

TEST(ChildProcessTest, HearsThatTheWorkIsDone) {
  const auto child = RunShell("worker", "echo half; echo finished; exec sleep 100");
  ASSERT_TRUE(child.ok());
  EXPECT_TRUE((*child)->WaitUntilFinished(absl::Seconds(10)));
  EXPECT_FALSE((*child)->end().has_value());
  const auto busy = RunShell("busy", "echo not finished; exec sleep 100");
  ASSERT_TRUE(busy.ok());
  EXPECT_FALSE((*busy)->WaitUntilFinished(absl::Milliseconds(200)));
}

TEST(ChildProcessTest, TellsHowItEnded) {
  const auto child = RunShell("failing", "echo no such vocabulary >&2; exit 3");
  ASSERT_TRUE(child.ok());
  ASSERT_TRUE((*child)->WaitForEnd(absl::Seconds(10)));
  EXPECT_EQ((*child)->end()->exit_code, 3);
  EXPECT_GT((*child)->end()->peak_rss_mb, 0.1);
  EXPECT_THAT(std::string((*child)->EndStatus().message()), HasSubstr("no such vocabulary"));
  EXPECT_THAT(std::string((*child)->WaitForAddress(absl::Seconds(10)).status().message()),
              HasSubstr("no such vocabulary"));
}

TEST(ChildProcessTest, KillsWhatDoesNotStop) {
  const auto child = RunShell("deaf", "trap '' TERM; echo listening on a:1; while :; do :; done");
  ASSERT_TRUE(child.ok());
  ASSERT_TRUE((*child)->WaitForAddress(absl::Seconds(10)).ok());
  EXPECT_EQ((*child)->Stop(absl::Milliseconds(100)).exit_code, 128 + 9);
}

TEST(ChildProcessTest, NamesAProgramThatIsNotThere) {
  const auto child = ChildProcess::Start("none", {"/nowhere/program"}, LogPath("none"));
  ASSERT_TRUE(child.ok());
  ASSERT_TRUE((*child)->WaitForEnd(absl::Seconds(10)));
  EXPECT_EQ((*child)->end()->exit_code, 127);
  EXPECT_EQ(FindProgramBeside("no_such_program").status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace corbslam::services
