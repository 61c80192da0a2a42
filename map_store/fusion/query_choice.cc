#include "map_store/fusion/query_choice.h"

#include <algorithm>
#include <tuple>

#include "map_store/fusion/overlap_query.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// So many local maps are looked in because they hold what looks most like the keyframe. Of 327
// overlaps that were accepted among 12 local maps, 311 were with one of the best two that had none
// close by (docs/lab/2026-11-28-look-ups.md).
constexpr size_t kMostAlike = 2;
// A place that is linked to so many other local maps of its island is known.
constexpr size_t kEnoughLinks = 2;

struct Prospect {
  LocalMapId local_map;
  size_t place_in_queue = 0;
  double likeness = 0;
  bool is_seam = false;
  bool is_joined = false;     // With the query's local map, in one island, or it is that one.
  bool is_of_island = false;  // It is another one that is joined.
};

bool AreJoined(const MissionState& state, LocalMapId a, LocalMapId b) {
  return state.FindIslandOf(a) == state.FindIslandOf(b);
}

// Lists the local maps in which something is to be verified, the most alike first. Once a place is
// linked to others of its island, the rest of the island, which is linked to these, has nothing
// new: else each visit would query all visits before it.
absl::StatusOr<std::vector<Prospect>> ListProspects(const MissionState& state,
                                                    const MapStoreOptions& options,
                                                    LongRead& read) {
  const KeyframeId query = state.queries.front().query;
  const LocalMapId own = state.OwnerOf(query.local_map);
  const std::vector<LocalMapId> against = state.queries.AgainstOfFront();
  std::vector<Prospect> prospects;
  size_t links = 0;
  for (size_t i = 0; i < against.size(); ++i) {
    RETURN_IF_ERROR(read.Pause());
    const FoundPlaces found = FindCandidates(state, {query, against[i], 0}, options);
    const bool is_joined = AreJoined(state, query.local_map, against[i]);
    const bool is_own = state.OwnerOf(against[i]) == own;
    links += found.are_linked && is_joined && !is_own;
    if (found.candidates.empty()) continue;
    prospects.push_back(
        {against[i], i, found.likeness, found.is_seam, is_joined, is_joined && !is_own});
  }
  if (links >= kEnoughLinks) {
    std::erase_if(prospects, [](const Prospect& prospect) { return prospect.is_of_island; });
  }
  std::ranges::sort(prospects, {}, [](const Prospect& prospect) {
    return std::make_tuple(-prospect.likeness, prospect.place_in_queue);
  });
  return prospects;
}

}  // namespace

LocalMapId ChooseNextToQuery(const MissionState& state) {
  const std::vector<LocalMapId> waiting = state.queries.WaitingLocalMaps();
  if (waiting.empty()) return LocalMapId();
  return *std::ranges::min_element(waiting, {}, [&state](LocalMapId id) {
    const Island* island = state.FindIslandOf(id);
    const LocalMapState* local_map = state.FindLocalMap(id);
    const bool is_joined = island != nullptr && island->local_maps.size() > 1;
    return std::make_tuple(is_joined, local_map == nullptr || local_map->closed);
  });
}

absl::StatusOr<std::vector<LocalMapId>> ChooseQueriedMaps(const MissionState& state,
                                                          const MapStoreOptions& options,
                                                          LongRead& read) {
  if (state.queries.empty()) return std::vector<LocalMapId>();
  ASSIGN_OR_RETURN(const std::vector<Prospect> prospects, ListProspects(state, options, read));
  std::vector<Prospect> chosen;
  bool looks_elsewhere = false;
  for (size_t i = 0; i < prospects.size(); ++i) {
    const Prospect& prospect = prospects[i];
    const bool is_news = !prospect.is_joined && !looks_elsewhere;
    if (i >= kMostAlike && !is_news && !prospect.is_seam) continue;
    chosen.push_back(prospect);
    looks_elsewhere = looks_elsewhere || !prospect.is_joined;
  }
  std::ranges::sort(chosen, {}, &Prospect::place_in_queue);
  std::vector<LocalMapId> local_maps;
  for (const Prospect& prospect : chosen) local_maps.push_back(prospect.local_map);
  return local_maps;
}

}  // namespace corbslam::map_store
