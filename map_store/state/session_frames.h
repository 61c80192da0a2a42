// Tells apart the sessions whose frames stand in one local map.
#ifndef CORBSLAM_MAP_STORE_STATE_SESSION_FRAMES_H_
#define CORBSLAM_MAP_STORE_STATE_SESSION_FRAMES_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// The frames of one session, whose clock says nothing of another's: the first of each kind, and the
// one after the last.
struct SessionFrames {
  LocalMapId id;  // The local map's name, or that of the part that the session was.
  size_t first = 0;
  size_t first_lost = 0;
  size_t end = 0;
  size_t end_lost = 0;
  // The same as LocalMapState's. The newest frame means nothing where the session has no frame.
  size_t newest_frame = 0;
  int64_t newest_lost_ns = 0;
};

// Returns the local map's own session, and then those of its parts as they became parts.
std::vector<SessionFrames> SessionsOf(const LocalMapState& local_map);

// Finds the newest frames of the local map and of each part anew. The caller, who has read a state
// from somewhere, does so once.
void NoteNewestOfSessions(LocalMapState& local_map);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_SESSION_FRAMES_H_
