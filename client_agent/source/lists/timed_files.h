// Reads lines of "time file", once or twice a line, separated by space, tabs or a comma.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_TIMED_FILES_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_TIMED_FILES_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/source/source_finding.h"

namespace corbslam::client_agent {

struct TimedFile {
  int64_t timestamp_ns = 0;
  int line = 0;
  std::string path;
};

// Reads all lines of the list at `path`, each with `per_line` files named from `directory` on. A
// first line of headings is passed over. Returns INVALID_ARGUMENT with line and field.
absl::StatusOr<std::vector<std::vector<TimedFile>>> ReadTimedFileLines(const std::string& directory,
                                                                       const std::string& path,
                                                                       size_t per_line);

// Reads a list with one file a line and returns it in the order of time; another order is a
// warning, a line that is there twice counts once. Returns INVALID_ARGUMENT where two files have
// one time.
absl::StatusOr<std::vector<TimedFile>> ReadTimedFiles(const std::string& directory,
                                                      const std::string& path,
                                                      SourceRemarks& remarks);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_TIMED_FILES_H_
