// Reads the lists of a store as lists of names, a page at a time.
#ifndef CORBSLAM_MAP_STORE_TESTING_NAME_LISTS_H_
#define CORBSLAM_MAP_STORE_TESTING_NAME_LISTS_H_

#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "map_store/store/map_store.h"

namespace corbslam::testing {

// Returns the name of an item of any list.
inline std::string NameOf(const map_store::MissionInfo& mission) { return mission.name; }
inline std::string NameOf(const map_store::AgentInfo& agent) { return agent.name; }
inline std::string NameOf(const map_store::LocalMapInfo& local_map) {
  return ToString(local_map.id);
}
inline std::string NameOf(const map_store::KeyframeInfo& keyframe) { return ToString(keyframe.id); }
inline std::string NameOf(const map_store::OverlapInfo& overlap) {
  return absl::StrCat(overlap.id);
}

struct Names {
  std::vector<std::string> names;
  std::string next_page_token;
};

template <typename T>
absl::StatusOr<Names> NamesOf(const absl::StatusOr<map_store::Page<T>>& page) {
  if (!page.ok()) return page.status();
  Names names;
  for (const T& item : page->items) names.names.push_back(NameOf(item));
  names.next_page_token = page->next_page_token;
  return names;
}

using List = std::function<absl::StatusOr<Names>(const map_store::PageRequest&)>;

inline List Missions(const map_store::MapStore& store) {
  return [&store](const map_store::PageRequest& page) { return NamesOf(store.ListMissions(page)); };
}
inline List Agents(const map_store::MapStore& store, const std::string& mission = "m") {
  return [&store, mission](const map_store::PageRequest& page) {
    return NamesOf(store.ListAgents(mission, page));
  };
}
inline List LocalMaps(const map_store::MapStore& store) {
  return [&store](const map_store::PageRequest& page) {
    return NamesOf(store.ListLocalMaps("m", page));
  };
}
inline List Keyframes(const map_store::MapStore& store, LocalMapId local_map) {
  return [&store, local_map](const map_store::PageRequest& page) {
    return NamesOf(store.ListKeyframes("m", local_map, page));
  };
}
inline List Overlaps(const map_store::MapStore& store,
                     const map_store::OverlapFilter& filter = {}) {
  return [&store, filter](const map_store::PageRequest& page) {
    return NamesOf(store.ListOverlaps("m", filter, page));
  };
}

// Returns the lists of mission "m", each with what it is a list of.
inline std::vector<std::pair<std::string, List>> AllLists(const map_store::MapStore& store,
                                                          LocalMapId a, LocalMapId b) {
  return {{"missions", Missions(store)},
          {"agents", Agents(store)},
          {"local maps", LocalMaps(store)},
          {"keyframes", Keyframes(store, {})},
          {"keyframes of one", Keyframes(store, a)},
          {"keyframes of the other", Keyframes(store, b)},
          {"overlaps", Overlaps(store)},
          {"accepted overlaps", Overlaps(store, {.accepted = true, .local_map = {}})},
          {"overlaps of one", Overlaps(store, {.accepted = std::nullopt, .local_map = a})}};
}

// Returns the names on all pages; calls `between` after each page.
inline std::vector<std::string> ReadInPages(
    const List& list, size_t page_size, const std::function<void()>& between = [] {}) {
  std::vector<std::string> all;
  map_store::PageRequest request = {page_size, ""};
  do {
    const auto page = list(request);
    EXPECT_TRUE(page.ok()) << page.status();
    if (!page.ok()) return all;
    EXPECT_LE(page->names.size(), page_size);
    all.insert(all.end(), page->names.begin(), page->names.end());
    request.page_token = page->next_page_token;
    between();
  } while (!request.page_token.empty());
  return all;
}

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_NAME_LISTS_H_
