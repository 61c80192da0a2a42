// MapStore's lists, a page at a time. Each list has an order that items keep as long as they are
// there, and describes only the items of the page.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "map_store/process/mission.h"
#include "map_store/process/mission_directory.h"
#include "map_store/store/map_store.h"
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

// Reads the numbers in a page's key, as many as `numbers` takes.
absl::Status ParseKeys(absl::string_view key, const std::vector<uint64_t*>& numbers) {
  const std::vector<absl::string_view> parts = absl::StrSplit(key, '/');
  if (parts.size() != numbers.size()) return NoSuchPageToken();
  for (size_t i = 0; i < parts.size(); ++i) {
    if (!absl::SimpleAtoi(parts[i], numbers[i])) return NoSuchPageToken();
  }
  return absl::OkStatus();
}

// The place of a local map in the order of arrival, as the numbers of a book (ArrivalBook) say it.
struct ArrivalPlace {
  bool is_first_page = true;
  uint64_t number = 0;
  uint64_t gone = 0;
};

using Arrivals = std::map<uint64_t, LocalMapId>;

// Returns where the list goes on. ABORTED where the numbers are of another book.
absl::StatusOr<Arrivals::const_iterator> FindArrival(const ArrivalPlace& place,
                                                     const ArrivalBook& book) {
  if (place.is_first_page) return book.names().begin();
  if (place.gone == book.gone()) return book.names().lower_bound(place.number);
  return absl::AbortedError(
      "the list changed: local maps were deleted or became one, and the mission was read from an "
      "older "
      "format since the page before; begin again, without a page_token");
}

std::string LocalMapKey(uint64_t number, const ArrivalBook& book) {
  return absl::StrCat(number, "/", book.gone());
}

// The place of a keyframe among those of one local map, or of all. Of all: by the arrival of the
// local map that it was made in, then by index. Of one: first its own, then those of its parts in
// the order in which they became parts, so that what becomes a part meanwhile comes behind.
struct KeyframePlace {
  ArrivalPlace local_map;
  // Of one local map: the one that the list began with. It may have become a part itself since, and
  // then the list ends with what stood before it.
  LocalMapId first;
  KeyframeId id;  // Of all local maps: its index only.
};

absl::StatusOr<KeyframePlace> ParseKeyframeKey(absl::string_view key, bool of_all) {
  KeyframePlace place;
  if (key.empty()) return place;
  place.local_map.is_first_page = false;
  uint64_t index = 0;
  RETURN_IF_ERROR(of_all ? ParseKeys(key, {&place.local_map.number, &place.local_map.gone, &index})
                         : ParseKeys(key, {&place.first.value, &place.id.local_map.value, &index}));
  if (index > std::numeric_limits<uint32_t>::max()) return NoSuchPageToken();
  place.id.index = static_cast<uint32_t>(index);
  return place;
}

// A keyframe, with the number of the local map that it was made in where all are listed.
struct ListedKeyframe {
  KeyframeId id;
  uint64_t number = 0;
};

// Appends keyframes that were made in `name`, those behind `after` if that is one of them, until
// there are `count`.
void ListKeyframesOf(LocalMapId name, KeyframeId after, uint64_t number, size_t count,
                     const LocalMapState& local_map, std::vector<ListedKeyframe>& listed) {
  const auto& keyframes = local_map.map.keyframes();
  auto it = after.local_map == name ? keyframes.upper_bound(after)
                                    : keyframes.lower_bound(KeyframeId{name, 0});
  for (; it != keyframes.end() && it->first.local_map == name && listed.size() < count; ++it) {
    listed.push_back({it->first, number});
  }
}

// Returns up to `count` keyframes of a local map behind a place.
absl::StatusOr<std::vector<ListedKeyframe>> KeyframesAfter(const LocalMapState& local_map,
                                                           const KeyframePlace& after,
                                                           size_t count) {
  std::vector<LocalMapId> names = local_map.Names();
  auto name = names.begin();
  if (!after.local_map.is_first_page) {
    const auto first = std::ranges::find(names, after.first);
    if (first == names.end()) return NoSuchPageToken();
    std::rotate(names.begin(), first, names.end());
    name = std::ranges::find(names, after.id.local_map);
    if (name == names.end()) return NoSuchPageToken();
  }
  std::vector<ListedKeyframe> listed;
  for (; name != names.end() && listed.size() < count; ++name) {
    ListKeyframesOf(*name, after.id, /*number=*/0, count, local_map, listed);
  }
  return listed;
}

// Returns up to `count` keyframes of all local maps behind a place.
absl::StatusOr<std::vector<ListedKeyframe>> KeyframesAfter(const MissionState& state,
                                                           const KeyframePlace& after,
                                                           size_t count) {
  std::vector<ListedKeyframe> listed;
  ASSIGN_OR_RETURN(auto arrival, FindArrival(after.local_map, state.arrivals));
  for (; arrival != state.arrivals.names().end() && listed.size() < count; ++arrival) {
    const auto& [number, name] = *arrival;
    const LocalMapState* local_map = state.FindLocalMap(name);
    if (local_map == nullptr) continue;
    const bool goes_on = !after.local_map.is_first_page && number == after.local_map.number;
    const KeyframeId behind = goes_on ? KeyframeId{name, after.id.index} : KeyframeId();
    ListKeyframesOf(name, behind, number, count, *local_map, listed);
  }
  return listed;
}

// `first`: the local map that the list began with, where it is one's.
std::string KeyframeKey(const ListedKeyframe& keyframe, LocalMapId first, const ArrivalBook& book) {
  return first.IsValid()
             ? absl::StrCat(first.value, "/", keyframe.id.local_map.value, "/", keyframe.id.index)
             : absl::StrCat(LocalMapKey(keyframe.number, book), "/", keyframe.id.index);
}

}  // namespace

absl::StatusOr<Page<MissionInfo>> MapStore::ListMissions(const PageRequest& request) const {
  ASSIGN_OR_RETURN(const PageStart start,
                   ReadPageStart(request, options_.max_page_size, "missions"));
  Page<MissionInfo> page;
  if (leases_ != nullptr) {
    ASSIGN_OR_RETURN(page.items, ListShared(start.after, start.size + 1));
    page.next_page_token =
        EndPage(start, page.items, [](const MissionInfo& mission) { return mission.name; });
    return page;
  }
  std::vector<KnownMission> missions = directory_->List(start.after, start.size + 1);
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
  ArrivalPlace after;
  if (!start.after.empty()) {
    after.is_first_page = false;
    RETURN_IF_ERROR(ParseKeys(start.after, {&after.number, &after.gone}));
    after.number = std::min(after.number, std::numeric_limits<uint64_t>::max() - 1) + 1;
  }
  return mission->WithState([&](const MissionState& state) -> absl::StatusOr<Page<LocalMapInfo>> {
    std::vector<std::pair<uint64_t, const LocalMapState*>> local_maps;
    ASSIGN_OR_RETURN(auto arrival, FindArrival(after, state.arrivals));
    for (; arrival != state.arrivals.names().end() && local_maps.size() <= start.size; ++arrival) {
      const auto it = state.local_maps.find(arrival->second);
      if (it != state.local_maps.end()) local_maps.emplace_back(arrival->first, &it->second);
    }
    Page<LocalMapInfo> page;
    page.next_page_token = EndPage(start, local_maps, [&state](const auto& item) {
      return LocalMapKey(item.first, state.arrivals);
    });
    for (const auto& [number, local_map] : local_maps) {
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
  const bool of_all = !local_map_id.IsValid();
  ASSIGN_OR_RETURN(const KeyframePlace after, ParseKeyframeKey(start.after, of_all));
  return mission->WithState([&](const MissionState& state) -> absl::StatusOr<Page<KeyframeInfo>> {
    std::vector<ListedKeyframe> listed;
    LocalMapId first = after.first;
    if (of_all) {
      ASSIGN_OR_RETURN(listed, KeyframesAfter(state, after, start.size + 1));
    } else {
      const LocalMapState* local_map = state.FindLocalMap(local_map_id);
      if (local_map == nullptr) return map_store::NoSuchLocalMap(local_map_id);
      if (!first.IsValid()) first = local_map->id;
      ASSIGN_OR_RETURN(listed, KeyframesAfter(*local_map, after, start.size + 1));
    }
    Page<KeyframeInfo> page;
    page.next_page_token = EndPage(start, listed, [&](const ListedKeyframe& keyframe) {
      return KeyframeKey(keyframe, first, state.arrivals);
    });
    std::vector<KeyframeId> ids;
    for (const ListedKeyframe& keyframe : listed) ids.push_back(keyframe.id);
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
      if (!map_store::Matches(filter, it->second.overlap, state)) continue;
      page.items.push_back(map_store::DescribeOverlap(state, it->second));
    }
    page.next_page_token = EndPage(
        start, page.items, [](const OverlapInfo& overlap) { return absl::StrCat(overlap.id); });
    return page;
  });
}

}  // namespace corbslam::map_store
