// Reads the list of pictures of one camera in EuRoC's layout: "time in nanoseconds,file".
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_CAMERA_LIST_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_CAMERA_LIST_H_

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/source/source_finding.h"

namespace corbslam::client_agent {

struct ListedPicture {
  int64_t timestamp_ns = 0;
  int line = 0;
  std::string file;  // Name of the file as the list has it.
};

// Reads CAMERA/data.csv, with or without a line of headings. Pictures come in the order of time; a
// list in another order is a warning in `remarks`. Returns INVALID_ARGUMENT, naming the line, for a
// time that is none, is negative or is there twice.
absl::StatusOr<std::vector<ListedPicture>> ReadCameraList(const std::string& camera_folder,
                                                          SourceRemarks& remarks);

// Pairs each picture of `left` with that of `right` nearest in time, each at most once, at most
// `tolerance_ns` apart. Both lists are in the order of time, which the pairs keep. What is left out
// is counted in `remarks`.
std::vector<std::pair<ListedPicture, ListedPicture>> PairByTime(
    const std::vector<ListedPicture>& left, const std::vector<ListedPicture>& right,
    int64_t tolerance_ns, SourceRemarks& remarks);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_CAMERA_LIST_H_
