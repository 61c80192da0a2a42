// Tests what a program says at its start where another one has its port or its folder.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "services/runtime/child_process.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using services::ChildProcess;

namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;

class InUseTest : public ::testing::Test {
 protected:
  InUseTest() {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }

  std::unique_ptr<ChildProcess> Start(const std::string& name, const std::string& program,
                                      std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), absl::StrCat(CORBSLAM_PROGRAMS_DIR, "/", program));
    arguments.push_back("--insecure");
    auto process = ChildProcess::Start(name, arguments, LogOf(name));
    EXPECT_TRUE(process.ok()) << process.status();
    return process.ok() ? *std::move(process) : nullptr;
  }
  // Waits until it serves; returns where.
  std::string AddressOf(ChildProcess& process) {
    const auto address = process.WaitForAddress(absl::Seconds(60));
    EXPECT_TRUE(address.ok()) << address.status();
    return address.value_or("");
  }
  // Returns what a program says that is to end by itself at once.
  std::string FailureOf(const std::string& program, const std::vector<std::string>& arguments) {
    const auto process = Start("second", program, arguments);
    if (process == nullptr) return "";
    EXPECT_TRUE(process->WaitForEnd(absl::Seconds(60))) << program << " runs";
    EXPECT_EQ(process->Stop(absl::ZeroDuration()).exit_code, 1) << program;
    return ReadText(LogOf("second"));
  }
  std::string FileOf(const std::string& name) const { return folder_ + "/" + name; }
  std::string LogOf(const std::string& name) const { return FileOf(name + ".log"); }

  const std::string folder_ =
      absl::StrCat(::testing::TempDir(), "/corbslam_in_use_",
                   ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(InUseTest, APortIsSaidWithTheProgramThatHasIt) {
  const auto worker = Start("first", "fusion_worker", {"--listen", "127.0.0.1:0"});
  ASSERT_NE(worker, nullptr);
  const std::string address = AddressOf(*worker);
  const std::string any = absl::StrCat("0.0.0.0", address.substr(address.rfind(':')));
  for (const std::string& wanted : {address, any}) {
    const std::string of_calls = FailureOf("map_store", {"--listen", wanted});
    EXPECT_THAT(of_calls, HasSubstr(absl::StrCat("can't listen on \"", wanted, "\"")));
    EXPECT_THAT(of_calls,
                ContainsRegex("process [0-9]+ \\(fusion_worker\\) has this port; stop it"));
    const std::string of_metrics =
        FailureOf("map_store", {"--listen", "127.0.0.1:0", "--metrics-listen", wanted});
    EXPECT_THAT(of_metrics, HasSubstr(absl::StrCat("metrics: can't listen on \"", wanted, "\"")));
    EXPECT_THAT(of_metrics, ContainsRegex("process [0-9]+ \\(fusion_worker\\) has this port"));
  }
}

TEST_F(InUseTest, OnePortForCallsAndMetricsIsSaid) {
  const auto first = Start("first", "fusion_worker", {"--listen", "127.0.0.1:0"});
  ASSERT_NE(first, nullptr);
  const std::string address = AddressOf(*first);
  first->Stop(absl::Seconds(30));
  EXPECT_THAT(FailureOf("fusion_worker", {"--listen", address, "--metrics-listen", address}),
              HasSubstr("this process itself has this port already; choose another one"));
}

TEST_F(InUseTest, AStoresFolderIsSaidWithTheProgramThatHasIt) {
  const auto store =
      Start("first", "map_store", {"--listen", "127.0.0.1:0", "--data-dir", FileOf("missions")});
  ASSERT_NE(store, nullptr);
  AddressOf(*store);
  const std::string said =
      FailureOf("map_store", {"--listen", "127.0.0.1:0", "--data-dir", FileOf("missions")});
  EXPECT_THAT(said, HasSubstr(FileOf("missions")));
  EXPECT_THAT(said, ContainsRegex("in use: process [0-9]+ \\(map_store\\) has it; stop it, or "));
}

TEST_F(InUseTest, ARobotsFolderIsSaidWithTheProgramThatHasIt) {
  const std::vector<std::string> robot = {
      "--source", DemoSource(),  "--server",      "127.0.0.1:1", "--mission",   "m",      "--agent",
      "a",        "--spool-dir", FileOf("spool"), "--listen",    "127.0.0.1:0", "--pace", "sensor"};
  const auto first = Start("first", "client_agent", robot);
  ASSERT_NE(first, nullptr);
  AddressOf(*first);
  const std::string said = FailureOf("client_agent", robot);
  EXPECT_THAT(said, HasSubstr(FileOf("spool")));
  EXPECT_THAT(said,
              ContainsRegex("in use: process [0-9]+ \\(client_agent\\) has it; stop it, or "));
}

}  // namespace
}  // namespace corbslam::tests
