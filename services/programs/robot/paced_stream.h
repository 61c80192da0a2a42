// Gives the frames of a stream at the pace at which a robot takes them.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_PACED_STREAM_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_PACED_STREAM_H_

#include <cstdint>
#include <optional>

#include "absl/status/statusor.h"
#include "absl/synchronization/notification.h"
#include "absl/time/time.h"
#include "client_agent/source/frame_stream.h"
#include "client_agent/source/kept_imu.h"
#include "services/programs/robot/source_pace.h"
#include "slam/util/named_values.h"

namespace corbslam::services {

enum class Pace {
  kSensor,  // Frames come in the stream's own time; those that come too fast are dropped.
  kMax,     // Frames come as fast as the agent takes them.
  kStep,    // As kMax, for an agent that does all its work on each frame before the next one.
};
inline constexpr NamedValues<Pace, 3> kPaces = {
    {{"max", Pace::kMax}, {"sensor", Pace::kSensor}, {"step", Pace::kStep}}};

// Plays one stream. One thread uses it, apart from `stop`. `stream` and `stop` must outlive it.
class PacedStream {
 public:
  PacedStream(client_agent::FrameStream& stream, Pace pace, const absl::Notification& stop)
      : stream_(stream), pace_(pace), stop_(stop) {}

  // Waits for the next frame to be tracked, and at kSensor until it is due by the times of its
  // drive; a camera's (StreamFrame::came) is due when it comes. Frames whose successor is there and
  // due already are dropped, as a camera's driver would; what an IMU measured before them comes
  // with the next. Returns nullopt after the last frame, and
  // when stopped; the stream's error once every frame before it was given.
  absl::StatusOr<std::optional<client_agent::StreamFrame>> Next();

  // Returns the number of frames dropped so far.
  uint64_t dropped() const { return dropped_; }
  // Returns how the stream keeps up with its own times, at kSensor; a live one is not watched.
  const SourcePace& source_pace() const { return source_pace_; }

 private:
  // Returns the stream's next frame, whenever it comes; nullopt as for Next.
  absl::StatusOr<std::optional<client_agent::StreamFrame>> Await();
  // Asks the stream. Where that makes its frames (FrameStream::is_live) and one was not made by the
  // time at which it was due, the clock waited: it's not the robot that is slow.
  absl::StatusOr<client_agent::NextFrame> Ask(absl::Time deadline);
  // Returns true if the stream has a frame, due by `now`, behind the one that Await gave last.
  bool IsOvertaken(absl::Time now);
  absl::Time Due(const client_agent::StreamFrame& frame) const;

  client_agent::FrameStream& stream_;
  const Pace pace_;
  const absl::Notification& stop_;
  uint64_t dropped_ = 0;
  SourcePace source_pace_;
  // What the stream answered when it was asked for the frame behind the one that waits to be due;
  // nullopt if it had none yet.
  std::optional<absl::StatusOr<client_agent::NextFrame>> ahead_;
  // When the first frame of this drive came, and its stamp in nanoseconds.
  std::optional<absl::Time> start_;
  int64_t first_ns_ = 0;
  int drive_ = 0;
  client_agent::KeptImu kept_imu_;  // Of frames that were dropped.
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_PACED_STREAM_H_
