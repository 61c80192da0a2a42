// What an agent lacks of the global layer, step by step within a byte budget (CORB-SLAM, section
// 2.3): others' keyframes and points, the nearest first, in full; moved ones light;
// landmark sets; where its own keyframes stand.
#ifndef CORBSLAM_MAP_STORE_SHARING_SHARING_H_
#define CORBSLAM_MAP_STORE_SHARING_SHARING_H_

#include <cstddef>
#include <optional>

#include "map_store/options.h"
#include "map_store/state/mission_state.h"
#include "map_store/state/share_state.h"
#include "map_store/view/long_read.h"
#include "slam/exchange/shared_update.h"

namespace corbslam::map_store {

// The next update for the agent, noted in `share` as sent; none when it has all. The agent's own
// local map is the one that it opened last; others' are shared once it is in one island with them.
// Own earlier local maps are others' by that rule. Another island's frame, or another local map,
// begins with `restart`. `read` pauses meanwhile (TakeShareStep); none also where `share` is left
// unfinished, and then it is to be asked again.
std::optional<SharedUpdate> TakeSharedUpdate(const MissionState& state,
                                             const MapStoreOptions& options, size_t byte_budget,
                                             const AgentState& agent, ShareState& share,
                                             LongRead& read);

// The update that was taken last did not reach the agent, or only a part of it was taken: it is
// told all again when it opens its next session.
void ForgetLastUpdate(ShareState& share);

// The agent opened a session and says up to which revision it has applied what it was sent: goes
// on from there if that is certain, else starts again.
void ResumeSharing(uint64_t last_revision, ShareState& share);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_SHARING_SHARING_H_
