// Plays a live camera, or a slow sequence, for a test.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_TESTING_QUEUED_STREAM_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_TESTING_QUEUED_STREAM_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "client_agent/source/frame_stream.h"

namespace corbslam::services {

// A stream of unknown length: it gives what a test puts in, in that order, and notes how it was
// asked. Not thread-safe.
class QueuedStream : public client_agent::FrameStream {
 public:
  void Put(absl::StatusOr<client_agent::NextFrame> next) { queue_.push_back(std::move(next)); }
  // Puts a frame without pictures.
  void PutFrame(size_t number, double time_s, int drive = 0) {
    client_agent::StreamFrame frame;
    frame.frame = {number, static_cast<int64_t>(time_s * 1e9), drive};
    frame.images.timestamp_ns = frame.frame.timestamp_ns;
    Put(client_agent::NextFrame(std::move(frame)));
  }
  // Puts a frame without pictures, before which an IMU measured at these times, nanoseconds.
  void PutImuFrame(size_t number, int64_t time_ns, const std::vector<int64_t>& measured_ns) {
    client_agent::StreamFrame frame;
    frame.frame = {number, time_ns, 0};
    frame.images.timestamp_ns = time_ns;
    for (const int64_t at_ns : measured_ns) frame.images.imu.push_back({at_ns, {}, {}});
    Put(client_agent::NextFrame(std::move(frame)));
  }
  // Returns the deadlines of the questions so far.
  const std::vector<absl::Time>& asked() const { return asked_; }
  // False: plays a sequence, of which each frame takes `makes_in` to be made.
  bool live = true;
  absl::Duration makes_in;
  std::optional<double> interval;  // What interval_s returns.
  // Called when nothing is left to give.
  std::function<void()> when_empty;
  // What left_out returns.
  client_agent::LeftOutFrames left_out_frames;
  client_agent::SourceFindings found;  // What findings returns.
  client_agent::PoseListener* listener = nullptr;

  const SensorCalibration& calibration() const override { return calibration_; }
  std::optional<double> interval_s() const override { return interval; }
  absl::StatusOr<client_agent::NextFrame> Next(absl::Time deadline) override {
    asked_.push_back(deadline);
    absl::SleepFor(makes_in);
    if (queue_.empty()) {
      if (when_empty != nullptr) when_empty();
      return client_agent::NoFrameYet();
    }
    absl::StatusOr<client_agent::NextFrame> next = std::move(queue_.front());
    queue_.pop_front();
    return next;
  }
  client_agent::LeftOutFrames left_out() const override { return left_out_frames; }
  client_agent::SourceFindings findings() const override { return found; }
  bool is_live() const override { return live; }
  client_agent::PoseListener* pose_listener() override { return listener; }

 private:
  std::deque<absl::StatusOr<client_agent::NextFrame>> queue_;
  std::vector<absl::Time> asked_;
  SensorCalibration calibration_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_TESTING_QUEUED_STREAM_H_
