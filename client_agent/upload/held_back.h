// Counts what waits in the robot's map to be told to the store, by kind and for how long.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_HELD_BACK_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_HELD_BACK_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>

#include "absl/time/time.h"
#include "slam/exchange/map_update.h"

namespace corbslam::client_agent {

// The kinds of items in a batch. What matters most comes first.
enum class UpdateKind {
  kPoses,        // Poses of tracked and lost frames, and of keyframes that the store knows.
  kKeyframes,    // Full keyframes.
  kPoints,       // Full points.
  kLightPoints,  // Positions that may have changed, of points that the store knows.
};
constexpr size_t kUpdateKinds = 4;
constexpr std::array<const char*, kUpdateKinds> kUpdateKindNames = {"poses", "keyframes", "points",
                                                                    "light_points"};

// Number of items of each kind, in the order of UpdateKind.
using UpdateCounts = std::array<size_t, kUpdateKinds>;

UpdateCounts CountUpdates(const MapUpdateBatch& batch);

// What is held back: not in a batch yet.
struct HeldBack {
  UpdateCounts items = {};
  // How long the oldest item of each kind has waited, if items go in the order in which they came.
  std::array<absl::Duration, kUpdateKinds> waited = {};

  bool IsNothing() const { return items == UpdateCounts{}; }
};

// Writes "3 keyframes, 120 points", or "nothing".
std::string ToString(const UpdateCounts& counts);

// Tells how long items wait from how many there are. Not thread-safe.
class HeldBackWatch {
 public:
  // Notes that these items have gone into a batch.
  void NoteTaken(const UpdateCounts& taken);
  // Notes that these items wait now. Where the clock has gone back, they count as not having
  // waited.
  void NoteWaiting(const UpdateCounts& waiting, absl::Time now);
  HeldBack status(absl::Time now) const;

 private:
  // At `time`, `arrived` items had come since the beginning.
  struct Mark {
    uint64_t arrived = 0;
    absl::Time time;
  };
  struct Kind {
    uint64_t taken = 0;
    size_t waiting = 0;
    // The first mark is that of the oldest item that waits.
    std::deque<Mark> marks;
  };

  std::array<Kind, kUpdateKinds> kinds_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_HELD_BACK_H_
