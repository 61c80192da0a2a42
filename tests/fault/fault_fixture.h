// What the fault tests share: real processes in a folder of the test's own, and what a test does
// where it may not do what it needs.
#ifndef CORBSLAM_TESTS_FAULT_FAULT_FIXTURE_H_
#define CORBSLAM_TESTS_FAULT_FAULT_FIXTURE_H_

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "services/runtime/child_process.h"

namespace corbslam::tests {

// Skips the test where the status is an error, and fails it under continuous integration.
#define SKIP_UNLESS_PERMITTED(expression)                         \
  do {                                                            \
    const absl::Status permitted = (expression);                  \
    if (!permitted.ok()) {                                        \
      ASSERT_EQ(std::getenv("CI"), nullptr) << permitted;         \
      GTEST_SKIP() << "needs to be root on Linux: " << permitted; \
    }                                                             \
  } while (false)

// CORBSLAM_LONG_FAULTS=1: all cases, and long ones.
bool WantsLongFaults();
// Returns a recording of 26 s at 15 Hz for the long tests. Where there is none, the test fails.
std::string LongSource();

// Returns the number in an environment variable, or `otherwise` without one. A value that is no
// number fails the test.
int CountFromEnvironment(const char* variable, int otherwise);

class FaultTest : public ::testing::Test {
 protected:
  FaultTest();

  // Starts one of our programs; its output is in NAME.log. Returns null when it does not start,
  // which fails the test.
  std::unique_ptr<services::ChildProcess> Start(const std::string& name, const std::string& program,
                                                std::vector<std::string> arguments,
                                                const std::vector<std::string>& security = {
                                                    "--insecure"});
  // Has programs that are started from now on come from another folder than this build's.
  void StartFrom(std::string programs) { programs_ = std::move(programs); }
  // Sets further environment variables for programs that are started from now on.
  void StartWith(std::vector<std::pair<std::string, std::string>> variables) {
    variables_ = std::move(variables);
  }
  // Waits for the address that it says; returns an empty one when it says none, which fails the
  // test.
  static std::string AddressOf(services::ChildProcess* process);
  // Returns the metrics address of a process that was started under this name and has named it.
  std::string MetricsAddressOf(const std::string& name) const;

  std::string LogOf(const std::string& name) const { return FileOf(name + ".log"); }
  std::string FileOf(const std::string& name) const { return (folder_ / name).string(); }
  // Returns what `client_agent --stats` wrote, or null when there is nothing to read.
  static nlohmann::json ReadStatistics(const std::string& path);

  const std::filesystem::path folder_;

 private:
  std::string programs_;
  std::vector<std::pair<std::string, std::string>> variables_;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_FAULT_FAULT_FIXTURE_H_
