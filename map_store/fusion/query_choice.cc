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

// So many others of the island are asked whether the place is linked to them, the most alike first:
// links stand out as overlaps do.
constexpr size_t kMostAsked = 4;
// Where a place is known, an earlier visit in the query's own local map looks at least this share
// as much like it as what it is linked to does.
constexpr double kLeastShareOfKnown = 0.3;

struct Prospect {
  LocalMapId local_map;
  size_t place_in_queue = 0;
  double likeness = 0;
  bool is_seam = false;
  bool is_joined = false;     // With the query's local map, in one island, or it is that one.
  bool is_of_island = false;  // It is another one that is joined.
};

// Goes through the local maps that the queue's first keyframe may be looked up in. Its cost is that
// of words, and of a few local maps in which it looks closer, however many there are. Once a place
// is linked to others of its island, the rest of the island, which is linked to these, has nothing
// new: else each visit would query all visits before it.
class ProspectList {
 public:
  ProspectList(const MissionState& state, const MapStoreOptions& options)
      : state_(state), options_(options), query_(state.queries.front().query) {}

  // Lists those in which something is to be verified, the most alike first. ABORTED: as `read`
  // says.
  absl::StatusOr<std::vector<Prospect>> Take(LongRead& read) {
    if (state_.FindKeyframe(query_) == nullptr) return std::vector<Prospect>();
    FindLinkedByOverlaps();
    RETURN_IF_ERROR(FindAlike(read));
    std::vector<Prospect> prospects;
    size_t asked = 0;
    for (Prospect& prospect : alike_) {
      const bool is_asked = prospect.is_of_island && !prospect.is_seam;
      if (IsKnown(prospect) || (is_asked && asked == kMostAsked)) continue;
      asked += is_asked;
      RETURN_IF_ERROR(read.Pause());
      if (HasNews(prospect)) prospects.push_back(prospect);
    }
    std::erase_if(prospects, [this](const Prospect& prospect) { return IsKnown(prospect); });
    return prospects;
  }

 private:
  bool IsKnownGround() const { return links_ >= kEnoughLinks; }
  QueryTask TaskOf(LocalMapId against) const { return {query_, against, 0}; }

  // Returns whether the place is known, and the local map would say nothing new of it.
  bool IsKnown(const Prospect& prospect) const {
    if (!IsKnownGround() || !prospect.is_joined) return false;
    return prospect.is_of_island || prospect.likeness < kLeastShareOfKnown * likeness_of_known_;
  }

  // Keeps the local maps that no overlap close by links with the place, and counts the others.
  void FindLinkedByOverlaps() {
    const LocalMapId own = state_.OwnerOf(query_.local_map);
    const std::vector<LocalMapId> against = state_.queries.AgainstOfFront();
    for (size_t i = 0; i < against.size(); ++i) {
      if (state_.FindLocalMap(against[i]) == nullptr) continue;
      const bool is_joined =
          state_.FindIslandOf(query_.local_map) == state_.FindIslandOf(against[i]);
      const bool is_of_island = is_joined && state_.OwnerOf(against[i]) != own;
      if (HasOverlapNearby(state_, TaskOf(against[i]), options_)) {
        if (is_of_island) linked_.push_back(against[i]);
      } else {
        alike_.push_back({against[i], i, 0, false, is_joined, is_of_island});
      }
    }
    links_ = linked_.size();
  }

  absl::Status FindAlike(LongRead& read) {
    if (IsKnownGround()) {
      std::erase_if(alike_, [](const Prospect& prospect) { return prospect.is_of_island; });
    }
    linked_.resize(std::min(linked_.size(), kEnoughLinks));
    for (const LocalMapId id : linked_) {
      RETURN_IF_ERROR(read.Pause());
      NoteKnown(FindResemblance(state_, TaskOf(id), options_).likeness);
    }
    for (Prospect& prospect : alike_) {
      RETURN_IF_ERROR(read.Pause());
      const Resemblance found = FindResemblance(state_, TaskOf(prospect.local_map), options_);
      prospect.likeness = found.likeness;
      prospect.is_seam = found.is_seam;
    }
    std::erase_if(alike_, [](const Prospect& prospect) {
      return prospect.likeness == 0 && !prospect.is_seam;
    });
    std::ranges::sort(alike_, {}, [](const Prospect& prospect) {
      return std::make_tuple(-prospect.likeness, prospect.place_in_queue);
    });
    return absl::OkStatus();
  }

  // Returns whether there is something to be verified in the local map; links are counted.
  bool HasNews(Prospect& prospect) {
    const FoundPlaces found = FindCandidates(state_, TaskOf(prospect.local_map), options_);
    if (found.are_linked && prospect.is_of_island) {
      ++links_;
      NoteKnown(prospect.likeness);
    }
    prospect.is_seam = found.is_seam;
    return !found.candidates.empty();
  }

  void NoteKnown(double likeness) { likeness_of_known_ = std::max(likeness_of_known_, likeness); }

  const MissionState& state_;
  const MapStoreOptions& options_;
  const KeyframeId query_;
  std::vector<LocalMapId> linked_;  // Others of the island, by overlaps close by.
  double likeness_of_known_ = 0;    // Of what the place is linked to, as far as it was asked.
  size_t links_ = 0;  // How many others of the island the place is linked to, as far as was asked.
  std::vector<Prospect> alike_;
};

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
  ASSIGN_OR_RETURN(const std::vector<Prospect> prospects, ProspectList(state, options).Take(read));
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
