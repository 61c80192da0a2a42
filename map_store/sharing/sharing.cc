#include "map_store/sharing/sharing.h"

#include <algorithm>
#include <utility>

#include "map_store/sharing/global_place.h"
#include "map_store/sharing/robot_places.h"
#include "map_store/sharing/share_step.h"
#include "map_store/view/metres.h"

namespace corbslam::map_store {
namespace {

bool HasSent(const ShareState& share) {
  return !share.keyframes.empty() || !share.points.empty() || !share.landmarks.empty() ||
         !share.own_keyframes.empty();
}

// Returns whether a local map that the agent heard of is not in its island any more.
bool HasLostAny(const MissionState& state, const ShareState& share, const Island& island) {
  return std::ranges::any_of(share.seen_local_maps,
                             [&](LocalMapId id) { return state.FindIslandOf(id) != &island; });
}

void ForgetAll(ShareState& share) {
  const ShareScope scope = share.scope;
  share = ShareState();
  share.scope = scope;
}

// Forgets what was sent; if the agent has anything, it is told to forget it, too.
void StartAgain(LocalMapId local_map, IslandId island, ShareState& share) {
  const bool had_any = share.restart || HasSent(share) || share.global_from_local.has_value();
  ForgetAll(share);
  share.local_map = local_map;
  share.island = island;
  share.restart = had_any;
}

void NoteSent(uint64_t revision, ShareState& share) {
  share.updates_of_last_revision =
      share.last_revision == revision ? share.updates_of_last_revision + 1 : 1;
  share.last_revision = revision;
}

std::optional<SharedUpdate> TakeOfIsland(const MissionState& state, const Island& island,
                                         const MapStoreOptions& options, size_t byte_budget,
                                         ShareState& share, LongRead& read) {
  if (share.complete_at_version == island.shared_version && !share.restart) return std::nullopt;
  // The island itself may be another one after the step.
  const bool apart = island.id != state.ReferenceIsland();
  SharedUpdate update = TakeShareStep(state, island, options, byte_budget, share, read);
  update.apart = apart;
  update.in_metres = IsInMetres(state, island);
  update.local_map = share.local_map;
  const bool ends_places = std::exchange(share.more_places, update.more_places);
  if (update.IsEmpty() && !ends_places) return std::nullopt;
  NoteSent(update.revision, share);
  return update;
}

// Before anything else the agent is told that its frame is the global one.
std::optional<SharedUpdate> TakeForLocalisation(const MissionState& state,
                                                const MapStoreOptions& options, size_t byte_budget,
                                                const AgentState& agent, ShareState& share,
                                                LongRead& read) {
  const auto it = state.global.islands.find(state.ReferenceIsland());
  if (it == state.global.islands.end()) return std::nullopt;
  const auto& [id, island] = *it;
  if (share.local_map.IsValid() || share.island != id || HasLostAny(state, share, island)) {
    StartAgain(LocalMapId(), id, share);
  }
  if (agent.localised.has_value() && NoteSaidPlace(*agent.localised->camera_from_global, share)) {
    share.complete_at_version = 0;
  }
  if (share.global_from_local.has_value()) {
    return TakeOfIsland(state, island, options, byte_budget, share, read);
  }
  share.global_from_local = Similarity3d::Identity();
  SharedUpdate first;
  first.revision = state.global.revision;
  first.restart = std::exchange(share.restart, false);
  first.global_from_local = share.global_from_local;
  first.in_metres = IsInMetres(state, island);
  NoteSent(first.revision, share);
  return first;
}

}  // namespace

const LocalMapState* FindOwnLocalMap(const MissionState& state,
                                     const std::vector<LocalMapId>& local_maps) {
  if (local_maps.empty()) return nullptr;
  const LocalMapState* newest = state.FindLocalMap(local_maps.back());
  // Parts come after their whole.
  return newest == nullptr || !newest->joined.empty() ? nullptr : newest;
}

std::optional<SharedUpdate> TakeSharedUpdate(const MissionState& state,
                                             const MapStoreOptions& options, size_t byte_budget,
                                             const AgentState& agent, ShareState& share,
                                             LongRead& read) {
  share.unfinished = false;
  if (share.scope.mode == ShareMode::kNone) return std::nullopt;
  if (agent.localise_only) {
    return TakeForLocalisation(state, options, byte_budget, agent, share, read);
  }
  const LocalMapState* own_map = FindOwnLocalMap(state, agent.local_maps);
  if (own_map == nullptr) return std::nullopt;
  const LocalMapId own = own_map->id;
  const Island& island = *state.FindIslandOf(own);
  if (share.local_map != own || share.island != island.id || HasLostAny(state, share, island)) {
    StartAgain(own, island.id, share);
  }
  if (island.local_maps.size() < 2) {
    // The island may have been larger, under the same name.
    if (HasSent(share)) StartAgain(own, island.id, share);
    SharedUpdate alone;
    alone.revision = state.global.revision;
    alone.local_map = own;
    alone.restart = std::exchange(share.restart, false);
    if (!own_map->closed) alone.global_from_local = TakeGlobalPlace(state, share);
    if (alone.IsEmpty()) return std::nullopt;
    NoteSent(alone.revision, share);
    return alone;
  }
  return TakeOfIsland(state, island, options, byte_budget, share, read);
}

void ForgetLastUpdate(ShareState& share) { share.last_revision = 0; }

void EndSharing(ShareState& share) { ForgetAll(share); }

namespace {

// The agent keeps what it has. What the new scope takes in is found by a look at all there is; that
// what is too far away for it is kept apart anew.
void ChangeScope(const ShareScope& scope, ShareState& share) {
  share.scope = scope;
  share.far.TakeAll();
  share.look_at_all = true;
  share.complete_at_version = 0;
}

}  // namespace

void ResumeSharing(uint64_t last_revision, const ShareScope& scope, ShareState& share) {
  if (share.scope != scope) ChangeScope(scope, share);
  const bool certain = last_revision != 0 && last_revision == share.last_revision &&
                       share.updates_of_last_revision == 1;
  if (certain) return;
  const bool holds_any = last_revision != 0;
  ForgetAll(share);
  share.restart = holds_any;
}

}  // namespace corbslam::map_store
