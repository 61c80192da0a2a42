// Starts what benchmarks with real servers begin with.
#ifndef CORBSLAM_TESTS_BENCH_STARTED_SERVER_H_
#define CORBSLAM_TESTS_BENCH_STARTED_SERVER_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "services/runtime/child_process.h"
#include "tests/replay/recorded_uploads.h"

namespace corbslam::tests {

inline constexpr absl::Duration kStopTimeout = absl::Seconds(30);

struct StartedServer {
  std::unique_ptr<services::ChildProcess> process;
  std::string address;  // The address is on loopback.
};

// Starts the program `name` beside this one, without TLS, and returns once it listens. What it says
// goes to the file `log`.
absl::StatusOr<StartedServer> StartServer(const std::string& name,
                                          std::vector<std::string> arguments,
                                          const std::string& log);

// Returns what a robot uploads of each source, with the vocabulary that ships.
absl::StatusOr<std::vector<RecordedUploads>> RecordAll(const std::vector<std::string>& sources);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_BENCH_STARTED_SERVER_H_
