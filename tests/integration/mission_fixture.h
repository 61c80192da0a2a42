// Runs the real programs on a mission and reads what `corbslam run` wrote.
#ifndef CORBSLAM_TESTS_INTEGRATION_MISSION_FIXTURE_H_
#define CORBSLAM_TESTS_INTEGRATION_MISSION_FIXTURE_H_

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "services/runtime/child_process.h"

namespace corbslam::tests {

// Returns the part of TUM fr1_xyz that ships.
std::string DemoSource();

// Returns a folder of the shared recordings (CORBSLAM_DATA_DIR); nullopt where there are none.
// Without them a test must skip, or fail under continuous integration: see SKIP_WITHOUT_RECORDINGS.
std::optional<std::string> RecordingsFolder();

#define SKIP_WITHOUT_RECORDINGS()                                              \
  do {                                                                         \
    if (!RecordingsFolder().has_value()) {                                     \
      ASSERT_EQ(std::getenv("CI"), nullptr) << "CORBSLAM_DATA_DIR is not set"; \
      GTEST_SKIP() << "CORBSLAM_DATA_DIR is not set";                          \
    }                                                                          \
  } while (false)

// Runs `corbslam` with the arguments and a time limit; fails the test when it fails. Returns what
// it printed.
std::string RunTool(const std::vector<std::string>& arguments, int timeout_s = 600);

struct Mission {
  nlohmann::json report;
  std::string folder;  // Folder of all results.
};

// Runs `corbslam run` with the arguments and an --out folder of its own, named after the test and
// `name`.
Mission RunMission(std::vector<std::string> arguments, const std::string& name = "run",
                   int timeout_s = 900);

// A map store that keeps its missions and its worker as processes of their own, on ports that the
// system chooses; stopped with the object. Without an address when one did not start (which fails
// the test).
class RunningServers {
 public:
  RunningServers();
  ~RunningServers();
  RunningServers(const RunningServers&) = delete;
  RunningServers& operator=(const RunningServers&) = delete;

  const std::string& store_address() const { return store_address_; }
  // Returns whether neither has ended.
  bool Run() const;

 private:
  // Returns an empty address when it does not start.
  std::string Start(const std::string& program, std::vector<std::string> arguments);

  const std::string log_folder_;
  std::vector<std::unique_ptr<services::ChildProcess>> servers_;
  std::string store_address_;
};

std::string ReadText(const std::string& path);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_INTEGRATION_MISSION_FIXTURE_H_
