#include "map_store/state/session_frames.h"

#include <algorithm>
#include <limits>

namespace corbslam::map_store {
namespace {

void FindNewest(const LocalMapState& local_map, SessionFrames& session) {
  session.newest_frame = session.first;
  for (size_t i = session.first; i < session.end; ++i) {
    const bool is_newer =
        local_map.frames[i].timestamp_ns >= local_map.frames[session.newest_frame].timestamp_ns;
    if (is_newer) session.newest_frame = i;
  }
  session.newest_lost_ns = std::numeric_limits<int64_t>::min();
  for (size_t i = session.first_lost; i < session.end_lost; ++i) {
    session.newest_lost_ns = std::max(session.newest_lost_ns, local_map.lost_frames_ns[i]);
  }
}

}  // namespace

std::vector<SessionFrames> SessionsOf(const LocalMapState& local_map) {
  std::vector<SessionFrames> sessions(1);
  sessions.back().id = local_map.id;
  sessions.back().newest_frame = local_map.newest_frame;
  sessions.back().newest_lost_ns = local_map.newest_lost_ns;
  for (const JoinedLocalMap& part : local_map.joined) {
    sessions.back().end = part.first_frame;
    sessions.back().end_lost = part.first_lost_frame;
    sessions.push_back({.id = part.id,
                        .first = part.first_frame,
                        .first_lost = part.first_lost_frame,
                        .end = 0,
                        .end_lost = 0,
                        .newest_frame = part.newest_frame,
                        .newest_lost_ns = part.newest_lost_ns});
  }
  sessions.back().end = local_map.frames.size();
  sessions.back().end_lost = local_map.lost_frames_ns.size();
  return sessions;
}

void NoteNewestOfSessions(LocalMapState& local_map) {
  std::vector<SessionFrames> sessions = SessionsOf(local_map);
  for (SessionFrames& session : sessions) FindNewest(local_map, session);
  local_map.newest_frame = sessions[0].newest_frame;
  local_map.newest_lost_ns = sessions[0].newest_lost_ns;
  for (size_t i = 0; i < local_map.joined.size(); ++i) {
    local_map.joined[i].newest_frame = sessions[i + 1].newest_frame;
    local_map.joined[i].newest_lost_ns = sessions[i + 1].newest_lost_ns;
  }
}

}  // namespace corbslam::map_store
