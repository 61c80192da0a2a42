// Says at which place of the way each frame is taken, and when.
#ifndef CORBSLAM_SERVICES_SIMULATION_SEQUENCE_FRAME_CLOCK_H_
#define CORBSLAM_SERVICES_SIMULATION_SEQUENCE_FRAME_CLOCK_H_

#include <cstddef>
#include <cstdint>

#include "services/simulation/inertial/measured_motion.h"
#include "services/simulation/sequence/simulation_spec.h"

namespace corbslam {

// Immutable. Times are in nanoseconds.
class FrameClock {
 public:
  // Frames are taken `rate_hz` a second while the way, `way_ns` long, lasts.
  FrameClock(const SimulationSpec& spec, double rate_hz, int64_t way_ns);

  size_t frame_count() const { return frame_count_; }
  // Returns the time since the sequence began, which movers and the lens go by.
  int64_t ElapsedAt(size_t frame) const;
  int64_t TimestampAt(size_t frame) const;
  // Returns the time of the way, `since_ns` after the frame's shutter opened. It runs backwards
  // when turned.
  int64_t WayTimeAt(size_t frame, int64_t since_ns = 0) const;
  // Returns the time of the way at a time since the sequence began; of a sequence without a kidnap.
  int64_t WayTimeOf(int64_t elapsed_ns) const;
  // Returns the times since the sequence began between which the robot stands and drives as a body
  // can: none where the way ends first.
  TimeSpan PhysicalSpan() const;
  bool IsDark(size_t frame) const;

 private:
  // Returns how far along the way the robot is, in time of driving at its speed, so long after the
  // standing: the speed grows smoothly.
  int64_t SetOff(int64_t time_ns) const;
  int64_t Turned(int64_t time_ns) const;

  const SimulationSpec spec_;
  const double rate_hz_;
  size_t frame_count_ = 0;
  const int64_t way_ns_;
  int64_t standing_ns_ = 0;     // The robot sets off so long after the first frame.
  int64_t setting_off_ns_ = 0;  // So long after that it has its speed.
  int64_t turning_ns_ = 0;  // When turned, times on the way are those of going forward, from here.
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_SEQUENCE_FRAME_CLOCK_H_
