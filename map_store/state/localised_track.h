// Keeps the trajectory of an agent that only localises.
#ifndef CORBSLAM_MAP_STORE_STATE_LOCALISED_TRACK_H_
#define CORBSLAM_MAP_STORE_STATE_LOCALISED_TRACK_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "slam/camera/recorded_camera.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/uplink.h"

namespace corbslam::map_store {

// What one process of the agent said (LocalisedFrames). Its clock says nothing of another run's.
struct LocalisedRun {
  uint64_t id = 0;
  uint64_t last_number = 0;  // Of its parts.
  std::optional<RecordedCamera> recorded_camera;
  // The frames as they came, relative to others' keyframes, in units of the global frame.
  std::vector<TrackedFrame> frames;
  // Times without a pose; of those that follow each other the first and the last.
  std::vector<int64_t> lost_frames_ns;
};

struct LocalisedTrack {
  // In the order in which they began. Runs without any frame go when the next one begins.
  std::vector<LocalisedRun> runs;
  // Frames that were here and are not any more.
  uint64_t dropped = 0;
};

// With one run more the oldest goes.
inline constexpr size_t kMaxLocalisedRuns = 1000;

// Returns null if there is no such run.
const LocalisedRun* FindRun(const LocalisedTrack& track, uint64_t id);
size_t CountFrames(const LocalisedTrack& track);

// Adds a part, which comes next in its run or begins it. Where there are then more than
// `max_frames`, each second frame of all goes, until there are not: a long trajectory is coarser
// the older it is.
void AddPart(const LocalisedFrames& part, size_t max_frames, LocalisedTrack& track);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_LOCALISED_TRACK_H_
