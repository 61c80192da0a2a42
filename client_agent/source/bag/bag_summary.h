// Says for people what is in a bag, and what of it would be played.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_SUMMARY_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_SUMMARY_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/source/bag/bag_options.h"
#include "client_agent/source/source_finding.h"

namespace corbslam::client_agent {

struct BagTopicSummary {
  std::string name;
  std::string type;      // ROS 1's name of it, whatever ROS wrote it.
  std::string encoding;  // "cdr", "ros1".
  uint64_t messages = 0;
  uint64_t bytes = 0;
  double rate_hz = 0;  // 0: of fewer than two messages.
  // Of pictures and transforms what they hold, else whether the topic is used at all.
  std::string note;
};

struct BagSummary {
  std::string format;
  size_t files = 0;
  uint64_t messages = 0;
  int64_t first_ns = 0;  // By the recorder's time.
  int64_t last_ns = 0;
  std::vector<BagTopicSummary> topics;
  std::vector<std::string> notes;  // What is damaged or missing.
  // What would be played, a name and a value a line; empty where nothing can be.
  std::vector<std::pair<std::string, std::string>> played;
  SourceFindings findings;
  std::string lacking;  // Why nothing can be played.
};

// Reads through the bag. Errors name the file; a bag without anything to play is no error.
absl::StatusOr<BagSummary> SummariseBag(const BagOptions& options);

// Returns the lines of `corbslam bag info`.
std::string FormatBagSummary(const BagSummary& summary);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_SUMMARY_H_
