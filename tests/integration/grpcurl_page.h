// Reads the calls that a page like docs/grpcurl.md shows, and what it says they answer.
#ifndef CORBSLAM_TESTS_INTEGRATION_GRPCURL_PAGE_H_
#define CORBSLAM_TESTS_INTEGRATION_GRPCURL_PAGE_H_

#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam::tests {

// A call is: grpcurl -plaintext [-max-time SECONDS] [-d 'JSON'] ADDRESS list [SERVICE] |
// SERVICE/METHOD
struct GrpcurlCall {
  std::string line;  // The call as written.
  std::string address;
  std::string request = "{}";
  double max_time_s = 0;  // 0: not given.
  bool is_list = false;
  std::string target;  // Service or method; empty: list all services.
  std::string answer;  // The block that follows.
};

// INVALID_ARGUMENT shows the line that can't be understood, or has no answer.
absl::StatusOr<std::vector<GrpcurlCall>> ReadGrpcurlCalls(const std::string& markdown);

// Parses JSON documents that come one after the other, as grpcurl prints streams. INVALID_ARGUMENT.
absl::StatusOr<std::vector<nlohmann::json>> ParseDocuments(absl::string_view text);

// Returns the names of all fields, like "missions[].name".
std::set<std::string> FieldPaths(const std::vector<nlohmann::json>& documents);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_INTEGRATION_GRPCURL_PAGE_H_
