// Says at which place of the way each frame is taken, and when.
#ifndef CORBSLAM_SERVICES_SIMULATION_SEQUENCE_FRAME_CLOCK_H_
#define CORBSLAM_SERVICES_SIMULATION_SEQUENCE_FRAME_CLOCK_H_

#include <cstddef>
#include <cstdint>

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
  bool IsDark(size_t frame) const;

 private:
  const SimulationSpec spec_;
  const double rate_hz_;
  size_t frame_count_ = 0;
  int64_t standing_ns_ = 0;  // The robot sets off so long after the first frame.
  int64_t turning_ns_ = 0;   // When turned, times on the way are those of going forward, from here.
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_SEQUENCE_FRAME_CLOCK_H_
