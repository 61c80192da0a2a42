// What waits in the robot's map to be told to the store, by kind and for how long.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_HELD_BACK_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_HELD_BACK_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>

#include "absl/time/time.h"
#include "slam/exchange/map_update.h"

namespace corbslam {

// What matters most comes first.
enum class UpdateKind {
  kPoses,        // Of tracked and lost frames, and of keyframes that the store knows.
  kKeyframes,    // In full.
  kPoints,       // In full.
  kLightPoints,  // Places that may have changed, of points that the store knows.
};
constexpr size_t kUpdateKinds = 4;
constexpr std::array<const char*, kUpdateKinds> kUpdateKindNames = {"poses", "keyframes", "points",
                                                                    "light_points"};

// How many items of each kind, in the order of UpdateKind.
using UpdateCounts = std::array<size_t, kUpdateKinds>;

UpdateCounts CountUpdates(const MapUpdateBatch& batch);

struct HeldBack {
  UpdateCounts items = {};
  // How long the oldest of them has waited, if they go in the order in which they came.
  std::array<absl::Duration, kUpdateKinds> waited = {};

  bool IsNothing() const { return items == UpdateCounts{}; }
};

// "3 keyframes, 120 points"; "nothing".
std::string ToString(const UpdateCounts& counts);

// Tells how long items wait from how many there are. Not thread-safe.
class HeldBackWatch {
 public:
  // These have gone into a batch.
  void NoteTaken(const UpdateCounts& taken);
  // These wait now. Times that fall count as no time.
  void NoteWaiting(const UpdateCounts& waiting, absl::Time now);
  HeldBack status(absl::Time now) const;

 private:
  // So many had come by then, since the beginning.
  struct Mark {
    uint64_t arrived = 0;
    absl::Time time;
  };
  struct Kind {
    uint64_t taken = 0;
    size_t waiting = 0;
    // The first is of the oldest that waits.
    std::deque<Mark> marks;
  };

  std::array<Kind, kUpdateKinds> kinds_;
};

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_HELD_BACK_H_
