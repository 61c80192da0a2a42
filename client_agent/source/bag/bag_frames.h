// Makes frames of the messages of two topics.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_FRAMES_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_FRAMES_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/source/bag/bag_contents.h"
#include "client_agent/source/source_finding.h"

namespace corbslam::client_agent {

struct BagFrame {
  int64_t timestamp_ns = 0;  // Of the first picture.
  int drive = 0;
  RecordedPlace first;
  RecordedPlace second;
};

struct FramePairing {
  std::string bag;  // For messages.
  bool by_recording_time = false;
  int64_t within_ns = 0;
  // The second pictures were taken so much later than they are stamped.
  int64_t second_offset_ns = 0;
};

struct BagFrames {
  std::vector<BagFrame> frames;
  bool by_recording_time = false;
};

// Messages are taken in the order in which they were recorded, whatever the file's is; where time
// jumps back by more than a second another drive begins. Within a drive they are put in the order
// of time, of two with one time the first is taken, and each first picture is paired with the
// second one nearest in time. Of two publishers at the same time the one with more messages is
// taken. What is left out is told in `remarks`. INVALID_ARGUMENT says why no two are a pair.
absl::StatusOr<BagFrames> MakeBagFrames(const BagTopic& first, const BagTopic& second,
                                        const FramePairing& pairing, SourceRemarks& remarks);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_BAG_FRAMES_H_
