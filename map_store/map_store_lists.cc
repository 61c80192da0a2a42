// MapStore's lists, a page at a time. Each list has an order that items keep as long as they are
// there, and describes only the items of the page.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "map_store/map_store.h"
#include "map_store/mission/mission.h"
#include "map_store/mission/mission_directory.h"
#include "map_store/view/answers.h"
#include "map_store/view/page_tokens.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

namespace {

// Reads the number in a page's key; it is 0 for an empty key, that of the first page.
absl::StatusOr<uint64_t> ParseKey(absl::string_view key) {
  uint64_t number = 0;
  if (!key.empty() && !absl::SimpleAtoi(key, &number)) return NoSuchPageToken();
  return number;
}

// Returns how many of a mission's local maps come before the first one of the page.
absl::StatusOr<size_t> ParseLocalMapKey(absl::string_view key) {
  ASSIGN_OR_RETURN(const uint64_t last, ParseKey(key));
  if (key.empty()) return 0;
  return std::min(last, std::numeric_limits<uint64_t>::max() - 1) + 1;
}

// The place of a keyframe among all of a mission: by the arrival of its local map, then by index.
struct KeyframePlace {
  KeyframeId id;
  bool is_first_page = true;
};

absl::StatusOr<KeyframePlace> ParseKeyframeKey(absl::string_view key) {
  if (key.empty()) return KeyframePlace();
  KeyframePlace place;
  place.is_first_page = false;
  const std::vector<absl::string_view> parts = absl::StrSplit(key, '/');
  if (parts.size() != 2 || !absl::SimpleAtoi(parts[0], &place.id.local_map.value) ||
      !absl::SimpleAtoi(parts[1], &place.id.index)) {
    return NoSuchPageToken();
  }
  return place;
}

// A local map has keyframes of several names, and its place in the order may change.
std::string KeyframeKey(KeyframeId id) { return absl::StrCat(id.local_map.value, "/", id.index); }

// Returns up to `count` keyframes behind a place, of the local maps with an order of `begin` to
// `end` - 1. INVALID_ARGUMENT where the place's local map is there no more.
absl::StatusOr<std::vector<KeyframeId>> KeyframesAfter(const MissionState& state,
                                                       const KeyframePlace& after, size_t begin,
                                                       size_t end, size_t count) {
  const LocalMapState* at = after.is_first_page ? nullptr : state.FindLocalMap(after.id.local_map);
  if (!after.is_first_page && at == nullptr) return NoSuchPageToken();
  std::vector<KeyframeId> ids;
  for (size_t i = at == nullptr ? begin : std::max(begin, at->order); i < end && ids.size() < count;
       ++i) {
    const LocalMapState& local_map = *state.FindLocalMap(state.order[i]);
    const auto& keyframes = local_map.map.keyframes();
    auto it = &local_map == at ? keyframes.upper_bound(after.id) : keyframes.begin();
    for (; it != keyframes.end() && ids.size() < count; ++it) ids.push_back(it->first);
  }
  return ids;
}

}  // namespace

absl::StatusOr<Page<MissionInfo>> MapStore::ListMissions(const PageRequest& request) const {
  ASSIGN_OR_RETURN(const PageStart start,
                   ReadPageStart(request, options_.max_page_size, "missions"));
  std::vector<KnownMission> missions = directory_->List(start.after, start.size + 1);
  Page<MissionInfo> page;
  page.next_page_token =
      EndPage(start, missions, [](const KnownMission& known) { return known.name; });
  for (const KnownMission& known : missions) page.items.push_back(Describe(known));
  return page;
}

absl::StatusOr<Page<AgentInfo>> MapStore::ListAgents(absl::string_view mission_name,
                                                     const PageRequest& request) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  ASSIGN_OR_RETURN(const PageStart start, ReadPageStart(request, options_.max_page_size,
                                                        absl::StrCat(mission_name, "/agents")));
  Page<AgentInfo> agents = mission->WithState([&start](const MissionState& state) {
    Page<AgentInfo> page;
    for (auto it = state.agents.upper_bound(start.after);
         it != state.agents.end() && page.items.size() <= start.size; ++it) {
      page.items.push_back(map_store::DescribeAgent(state, it->first, it->second));
    }
    page.next_page_token =
        EndPage(start, page.items, [](const AgentInfo& agent) { return agent.name; });
    return page;
  });
  mission->sessions().DescribeTold(agents.items);
  return agents;
}

absl::StatusOr<Page<LocalMapInfo>> MapStore::ListLocalMaps(absl::string_view mission_name,
                                                           const PageRequest& request) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  ASSIGN_OR_RETURN(const PageStart start, ReadPageStart(request, options_.max_page_size,
                                                        absl::StrCat(mission_name, "/localMaps")));
  ASSIGN_OR_RETURN(const size_t first, ParseLocalMapKey(start.after));
  return mission->WithState([&start, first](const MissionState& state) {
    std::vector<const LocalMapState*> local_maps;
    for (size_t i = first; i < state.order.size() && local_maps.size() <= start.size; ++i) {
      local_maps.push_back(state.FindLocalMap(state.order[i]));
    }
    Page<LocalMapInfo> page;
    page.next_page_token = EndPage(start, local_maps, [](const LocalMapState* local_map) {
      return absl::StrCat(local_map->order);
    });
    for (const LocalMapState* local_map : local_maps) {
      page.items.push_back(map_store::DescribeLocalMap(state, *local_map));
    }
    return page;
  });
}

absl::StatusOr<Page<KeyframeInfo>> MapStore::ListKeyframes(absl::string_view mission_name,
                                                           LocalMapId local_map_id,
                                                           const PageRequest& request) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  const std::string list = absl::StrCat(mission_name, "/keyframes/",
                                        local_map_id.IsValid() ? ToString(local_map_id) : "");
  ASSIGN_OR_RETURN(const PageStart start, ReadPageStart(request, options_.max_page_size, list));
  ASSIGN_OR_RETURN(const KeyframePlace after, ParseKeyframeKey(start.after));
  return mission->WithState([&](const MissionState& state) -> absl::StatusOr<Page<KeyframeInfo>> {
    size_t begin = 0;
    size_t end = state.order.size();
    if (local_map_id.IsValid()) {
      const LocalMapState* local_map = state.FindLocalMap(local_map_id);
      if (local_map == nullptr) return map_store::NoSuchLocalMap(local_map_id);
      begin = local_map->order;
      end = begin + 1;
    }
    ASSIGN_OR_RETURN(std::vector<KeyframeId> ids,
                     KeyframesAfter(state, after, begin, end, start.size + 1));
    Page<KeyframeInfo> page;
    page.next_page_token = EndPage(start, ids, [](KeyframeId id) { return KeyframeKey(id); });
    page.items = map_store::DescribeKeyframes(state, ids);
    return page;
  });
}

absl::StatusOr<Page<OverlapInfo>> MapStore::ListOverlaps(absl::string_view mission_name,
                                                         const OverlapFilter& filter,
                                                         const PageRequest& request) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<Mission> mission, FindMission(mission_name));
  const std::string list = absl::StrCat(
      mission_name, "/overlaps/", filter.accepted.has_value() ? absl::StrCat(*filter.accepted) : "",
      "/", filter.local_map.IsValid() ? ToString(filter.local_map) : "");
  ASSIGN_OR_RETURN(const PageStart start, ReadPageStart(request, options_.max_page_size, list));
  ASSIGN_OR_RETURN(const uint64_t after, ParseKey(start.after));
  return mission->WithState([&](const MissionState& state) {
    Page<OverlapInfo> page;
    const auto& overlaps = state.global.overlaps.entries();
    for (auto it = overlaps.upper_bound(after);
         it != overlaps.end() && page.items.size() <= start.size; ++it) {
      if (!map_store::Matches(filter, it->second.overlap)) continue;
      page.items.push_back(map_store::DescribeOverlap(state, it->second));
    }
    page.next_page_token = EndPage(
        start, page.items, [](const OverlapInfo& overlap) { return absl::StrCat(overlap.id); });
    return page;
  });
}

}  // namespace corbslam::map_store
