// Logs which frames a stream leaves out: each file of a recording that can't be read, and of a
// camera seldom and with counts, since one whose pictures find no counterpart may leave out all.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_LEFT_OUT_LOG_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_LEFT_OUT_LOG_H_

#include <cstdint>
#include <string>

#include "absl/time/time.h"
#include "client_agent/source/frame_stream.h"

namespace corbslam::services {

// Not thread-safe.
class LeftOutLog {
 public:
  // Logs what was left out since it was logged last, of a camera at most every 10 s. Returns how
  // many were left out so far.
  uint64_t Tell(const client_agent::FrameStream& stream, absl::Time now);

 private:
  uint64_t told_ = 0;
  absl::Time next_ = absl::InfinitePast();
};

// Returns a sentence about all that was left out, for the end of a run.
std::string DescribeLeftOut(const client_agent::FrameStream& stream,
                            const client_agent::LeftOutFrames& left_out);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_LEFT_OUT_LOG_H_
