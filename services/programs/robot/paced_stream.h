// The frames of a stream at the pace at which a robot takes them.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_PACED_STREAM_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_PACED_STREAM_H_

#include <cstdint>
#include <optional>

#include "absl/status/statusor.h"
#include "absl/synchronization/notification.h"
#include "absl/time/time.h"
#include "client_agent/source/frame_stream.h"

namespace corbslam {

enum class Pace {
  kSensor,  // In the stream's own time; frames that come too fast are dropped.
  kMax,     // As fast as the agent takes them.
};

// One thread, apart from `stop`. Both outlive it.
class PacedStream {
 public:
  PacedStream(FrameStream& stream, Pace pace, const absl::Notification& stop)
      : stream_(stream), pace_(pace), stop_(stop) {}

  // Waits for the next frame that is to be tracked, at kSensor until it is due. Frames whose
  // successor is there and due already are dropped, as a camera's driver would. nullopt after the
  // last, and when stopped; the stream's error once every frame before it was given.
  absl::StatusOr<std::optional<StreamFrame>> Next();

  // So far.
  uint64_t dropped() const { return dropped_; }

 private:
  // The frame after the last one that this gave, whenever it comes; nullopt as for Next.
  absl::StatusOr<std::optional<StreamFrame>> Await();
  // Whether the stream has a frame, due by `now`, behind the one that Await gave last.
  bool IsOvertaken(absl::Time now);
  absl::Time Due(const StreamFrame& frame) const;

  FrameStream& stream_;
  const Pace pace_;
  const absl::Notification& stop_;
  uint64_t dropped_ = 0;
  // What the stream said when it was asked for the frame behind the one that is waited with.
  std::optional<absl::StatusOr<NextFrame>> ahead_;
  // When the first frame came, and its stamp.
  std::optional<absl::Time> start_;
  int64_t first_ns_ = 0;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_PACED_STREAM_H_
