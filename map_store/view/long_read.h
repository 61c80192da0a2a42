// Reads much of a mission's state without keeping its writers waiting until the end.
#ifndef CORBSLAM_MAP_STORE_VIEW_LONG_READ_H_
#define CORBSLAM_MAP_STORE_VIEW_LONG_READ_H_

#include <cstddef>

#include "absl/status/status.h"

namespace corbslam::map_store {

// A read in pieces. Between two pieces owners' batches may be applied: items come, move and go, and
// pointers into the maps end. What fusion and people decide stays as it was.
class LongRead {
 public:
  virtual ~LongRead() = default;
  // Ends a piece. Returns ABORTED if the global layer has changed, or nobody wants the work any
  // more; what was read so far is worth nothing then.
  virtual absl::Status Pause() = 0;
};

// A read in one piece.
class UnbrokenRead : public LongRead {
 public:
  absl::Status Pause() override { return absl::OkStatus(); }
};

// Counts the items that a read looks at, a step each, and ends a piece after so many.
class StepsInPieces {
 public:
  // The read is not owned and must outlive this.
  StepsInPieces(LongRead& read, size_t steps_in_a_piece) : read_(read), limit_(steps_in_a_piece) {}

  // Adds what the caller has looked at since the last call. Returns what Pause does where a piece
  // ends here.
  absl::Status Advance(size_t steps = 1) {
    steps_ += steps;
    if (steps_ < limit_) return absl::OkStatus();
    steps_ = 0;
    return read_.Pause();
  }

 private:
  LongRead& read_;
  const size_t limit_;
  size_t steps_ = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_LONG_READ_H_
