// Reads the lists of an RGB-D recording in the TUM benchmark's format: which picture goes with
// which depth image, and when they were taken.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_RGBD_LISTS_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_RGBD_LISTS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/source/source_finding.h"

namespace corbslam::client_agent {

struct RgbdPair {
  int64_t timestamp_ns = 0;  // Time of the picture.
  int64_t depth_timestamp_ns = 0;
  int line = 0;
  std::string grey;  // Paths of the two files.
  std::string depth;
};

// Depth images were taken `depth_offset_ns` later than they are stamped.

// Returns the first of DIR/associated.txt, associations.txt, association.txt or associate.txt that
// is there; empty where none is.
std::string FindAssociations(const std::string& directory);

// Reads "time file time file" a line, the picture first or the depth image first: a file in a
// folder depth/ or depth.../, or else the one of 16 bits, is the depth image. Pairs that are more
// than 50 ms apart are left out and counted. Returns INVALID_ARGUMENT with line and field.
absl::StatusOr<std::vector<RgbdPair>> ReadAssociations(const std::string& directory,
                                                       const std::string& path,
                                                       int64_t depth_offset_ns,
                                                       SourceRemarks& remarks);

// Reads DIR/rgb.txt alone, "time file" a line, in the order of the list; there are no depth images.
absl::StatusOr<std::vector<RgbdPair>> ListPicturesAlone(const std::string& directory,
                                                        SourceRemarks& remarks);

// Reads DIR/rgb.txt and DIR/depth.txt, "time file" a line, and pairs them by growing difference in
// time, each file once, at most 20 ms apart; returns them in the order of time. What has no
// counterpart is counted.
absl::StatusOr<std::vector<RgbdPair>> PairLists(const std::string& directory,
                                                int64_t depth_offset_ns, SourceRemarks& remarks);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_RGBD_LISTS_H_
