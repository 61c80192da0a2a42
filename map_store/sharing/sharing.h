// Tells an agent what it lacks of the global layer, step by step within a byte budget (CORB-SLAM,
// section 2.3): others' keyframes and points in full, the nearest first; moved ones light;
// landmarks; where its own keyframes stand. An agent may want less of it (ShareScope): then it gets
// fewer of others' keyframes or none, and no points and landmarks but those that these see.
#ifndef CORBSLAM_MAP_STORE_SHARING_SHARING_H_
#define CORBSLAM_MAP_STORE_SHARING_SHARING_H_

#include <cstddef>
#include <optional>
#include <vector>

#include "map_store/options/options.h"
#include "map_store/state/mission_state.h"
#include "map_store/state/share_state.h"
#include "map_store/view/long_read.h"
#include "slam/exchange/shared_update.h"

namespace corbslam::map_store {

// Returns an agent's own local map, by those that it has in the order of their arrival: the one
// that it opened last. Null if there is none, or if that one has become a part of an earlier one,
// whose frame is not the agent's: it has no own one until it opens the next.
const LocalMapState* FindOwnLocalMap(const MissionState& state,
                                     const std::vector<LocalMapId>& local_maps);

// Returns the next update for the agent, and notes it in `share` as sent; none if the agent has
// all. The agent's own local map is the one that it opened last. Other local maps, its own earlier
// ones among them, are shared once its own is in one island with them. Another island's frame, or
// another local map, begins with `restart`. An agent whose local map is alone in the reference
// island is told where it lies in the global frame, and nothing else: as long as it
// is open, since the agent holds that of whatever local map it goes on in. `read` pauses meanwhile
// (TakeShareStep). If it returns none and `share` is left unfinished, the caller is to ask again.
// An agent that localises only is told of the reference island, as if it had a keyframe where it
// said that it was; its own frame is that island's.
std::optional<SharedUpdate> TakeSharedUpdate(const MissionState& state,
                                             const MapStoreOptions& options, size_t byte_budget,
                                             const AgentState& agent, ShareState& share,
                                             LongRead& read);

// The caller says that the update that was taken last did not reach the agent, or that only a part
// of it was taken: the agent is told all again when it opens its next session.
void ForgetLastUpdate(ShareState& share);

// The caller says that the agent has ended: what it was sent is forgotten. Should it come again, it
// is told all again.
void EndSharing(ShareState& share);

// The caller says that the agent opened a session, and up to which revision it has applied what it
// was sent. Sharing goes on from there if that is certain, else it starts again. `scope` is what it
// wants from now on: what it was sent stays and, unless it wants nothing, is kept up to date.
void ResumeSharing(uint64_t last_revision, const ShareScope& scope, ShareState& share);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_SHARING_SHARING_H_
