#include "map_store/records/retraction.h"

#include <algorithm>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/fusion/overlap_query.h"
#include "map_store/fusion/rederivation.h"
#include "map_store/records/record_application.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

bool IsAcceptedEntry(const OverlapEntry& entry) {
  return entry.state == OverlapState::kInGraph || entry.state == OverlapState::kWaiting;
}

// Returns the two local maps that have its keyframes by now: these may bear the names of parts.
std::pair<LocalMapId, LocalMapId> SidesOf(const Overlap& overlap, const MissionState& state) {
  const LocalMapId query = state.OwnerOf(overlap.query.local_map);
  const LocalMapId candidate = state.OwnerOf(overlap.candidate.local_map);
  return std::minmax(query, candidate);
}

std::pair<KeyframeId, KeyframeId> KeyframesOf(const Overlap& overlap) {
  return std::minmax(overlap.query, overlap.candidate);
}

std::vector<uint64_t> FindMeant(const RetractRecord& record, const MissionState& state) {
  if (!record.keep_apart) return {record.overlap};
  const OverlapLedger& overlaps = state.global.overlaps;
  const auto sides = SidesOf(overlaps.at(record.overlap).overlap, state);
  return FindLinks(*state.FindLocalMap(sides.first), *state.FindLocalMap(sides.second), overlaps);
}

void TakeBack(OverlapEntry& entry) {
  Refuse("taken back", OverlapState::kRefused, entry);
  entry.overlap.verdict = OverlapVerdict::kTakenBack;
  entry.revision = 0;
}

// Forgets what fusion placed, found wrong and made one of the members' own items.
void ForgetPlaces(const std::set<LocalMapId>& members, GlobalLayer& global) {
  const auto is_of_them = [&members](const auto& item) {
    return members.contains(item.first.local_map);
  };
  std::erase_if(global.keyframes, is_of_them);
  absl::erase_if(global.points, is_of_them);
  std::erase_if(global.heirs, is_of_them);
  std::erase_if(global.stand_ins, is_of_them);
  std::erase_if(global.rejected, [&members](const auto& item) {
    return members.contains(item.first.first.local_map);
  });
  std::erase_if(global.culled,
                [&members](KeyframeId id) { return members.contains(id.local_map); });
  global.landmarks.Dissolve(members);
  for (const LocalMapId& id : members) global.island_from_local.erase(id);
}

// Returns whether the overlap was believed, or is now that it bends no graph any more.
bool IsBelievedAgain(const OverlapEntry& entry, const MissionState& state) {
  const bool bent_the_graph =
      entry.state == OverlapState::kRefused && entry.overlap.verdict == OverlapVerdict::kBendsGraph;
  return IsAcceptedEntry(entry) || (bent_the_graph && !IsTakenBack(entry.overlap, state));
}

// Lets overlaps among the members wait to be fused, as if they had just been verified.
void WaitAgain(const std::set<LocalMapId>& members, const MapStoreOptions& options,
               MissionState& state) {
  std::vector<uint64_t> ids;
  for (const auto& [id, entry] : state.global.overlaps.entries()) {
    const bool is_among_them = members.contains(entry.overlap.query.local_map) &&
                               members.contains(entry.overlap.candidate.local_map);
    if (is_among_them && IsBelievedAgain(entry, state)) ids.push_back(id);
  }
  for (const uint64_t id : ids) {
    state.global.overlaps.Change(id, [&](OverlapEntry& entry) {
      Overlap& overlap = entry.overlap;
      state.statistics.overlaps_accepted += !IsAcceptedEntry(entry);
      overlap.verdict = OverlapVerdict::kAccepted;
      entry.state = OverlapState::kWaiting;
      entry.attempts = 0;
      entry.alone = false;
      entry.revision = 0;
      entry.note.clear();
      entry.urgent =
          state.OwnerOf(overlap.query.local_map) == state.OwnerOf(overlap.candidate.local_map) &&
          GraphResidualPx(state, overlap) > options.loop_residual_px;
    });
  }
}

void DissolveIsland(IslandId island_id, const MapStoreOptions& options, MissionState& state) {
  const std::vector<LocalMapId> local_maps = state.global.islands.at(island_id).local_maps;
  const std::set<LocalMapId> members(local_maps.begin(), local_maps.end());
  std::vector<Island> lone;
  for (const LocalMapId& id : members) lone.push_back(MakeLoneIsland(state, id));
  state.global.islands.erase(island_id);
  for (const LocalMapId& id : members) ForgetChanges(state, *state.FindLocalMap(id));
  for (Island& island : lone) {
    SetIslandOf(*state.FindLocalMap(island.id), island.id, state);
    state.global.islands[island.id] = std::move(island);
  }
  std::set<LocalMapId> names;
  for (const LocalMapId& id : members) {
    const std::vector<LocalMapId> parts = state.FindLocalMap(id)->Names();
    names.insert(parts.begin(), parts.end());
  }
  ForgetPlaces(names, state.global);
  WaitAgain(names, options, state);
}

}  // namespace

std::vector<uint64_t> FindLinks(const LocalMapState& a, const LocalMapState& b,
                                const OverlapLedger& overlaps) {
  OverlapLedger::Ids links;
  for (const LocalMapId& name_a : a.Names()) {
    for (const LocalMapId& name_b : b.Names()) {
      const OverlapLedger::Ids& live = overlaps.LiveBetween(name_a, name_b);
      links.insert(live.begin(), live.end());
    }
  }
  return {links.begin(), links.end()};
}

namespace {

// What joins two parts of one local map by now has given one of them its frame.
absl::Status CheckNotInside(const MissionState& state, uint64_t id, const Overlap& overlap) {
  const LocalMapId query = overlap.query.local_map;
  const LocalMapId candidate = overlap.candidate.local_map;
  const LocalMapId whole = state.OwnerOf(query);
  if (query == candidate || whole != state.OwnerOf(candidate)) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(
      "overlap ", id, " of mission ", state.name, " can't be taken back: it joined local maps ",
      ToString(query), " and ", ToString(candidate), ", which have been retired into one, ",
      ToString(whole), "; delete that session (`corbslam mission forget`), or restore a backup"));
}

}  // namespace

absl::Status CheckRetractable(const MissionState& state, uint64_t overlap) {
  const OverlapEntry* entry = state.global.overlaps.Find(overlap);
  if (entry == nullptr) {
    return absl::NotFoundError(absl::StrCat("mission ", state.name, " has no overlap ", overlap));
  }
  if (IsAcceptedEntry(*entry)) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat("overlap ", overlap, " of mission ", state.name,
                                                    " can't be taken back: it is ",
                                                    ToString(entry->overlap.verdict)));
}

absl::Status CheckRetraction(const MissionState& state, const RetractRecord& record) {
  RETURN_IF_ERROR(CheckRetractable(state, record.overlap));
  const Overlap& overlap = state.global.overlaps.at(record.overlap).overlap;
  RETURN_IF_ERROR(CheckNotInside(state, record.overlap, overlap));
  if (!record.keep_apart || overlap.query.local_map != overlap.candidate.local_map) {
    return absl::OkStatus();
  }
  return absl::FailedPreconditionError(
      absl::StrCat("overlap ", record.overlap, " of mission ", state.name,
                   " is a loop of local map ", ToString(overlap.query.local_map),
                   ", which can't be kept apart from itself: take back the overlap alone"));
}

std::vector<uint64_t> Retract(const RetractRecord& record, const MapStoreOptions& options,
                              MissionState& state) {
  GlobalLayer& global = state.global;
  const std::vector<uint64_t> meant = FindMeant(record, state);
  const Overlap named = global.overlaps.at(record.overlap).overlap;
  if (record.keep_apart) global.kept_apart.insert(SidesOf(named, state));
  bool held = false;
  for (const uint64_t id : meant) {
    const OverlapEntry& entry = global.overlaps.at(id);
    held = held || entry.state == OverlapState::kInGraph;
    global.taken_back.insert(KeyframesOf(entry.overlap));
    --state.statistics.overlaps_accepted;
    global.overlaps.Change(id, &TakeBack);
  }
  ++state.version;
  ++global.revision;
  if (!held) return meant;
  DissolveIsland(global.island_of.at(named.query.local_map), options, state);
  // While the overlap joined the two local maps, it hid what else they have in common.
  const auto [earlier, later] = SidesOf(named, state);
  if (!record.keep_apart) QueueAgain(*state.FindLocalMap(later), {earlier}, state);
  return meant;
}

bool IsTakenBack(const Overlap& overlap, const MissionState& state) {
  return state.global.taken_back.contains(KeyframesOf(overlap)) ||
         state.global.kept_apart.contains(SidesOf(overlap, state));
}

}  // namespace corbslam::map_store
