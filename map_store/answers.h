// Answers to look-ups, read from a mission's state.
#ifndef CORBSLAM_MAP_STORE_ANSWERS_H_
#define CORBSLAM_MAP_STORE_ANSWERS_H_

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "map_store/lookups.h"
#include "map_store/mission_state.h"

namespace corbslam::map_store {

MissionInfo DescribeMission(const MissionState& state);
std::vector<AgentInfo> DescribeAgents(const MissionState& state);
LocalMapInfo DescribeLocalMap(const MissionState& state, const LocalMapState& local_map);
// One after the other; the state has all of them.
std::vector<KeyframeInfo> DescribeKeyframes(const MissionState& state,
                                            const std::vector<KeyframeId>& ids);
MissionStatistics DescribeStatistics(const MissionState& state);
std::vector<OverlapInfo> DescribeOverlaps(const MissionState& state, const OverlapFilter& filter);
IslandView DescribeIsland(const MissionState& state, const Island& island);
// The reference island first, then by id.
std::vector<const Island*> OrderedIslands(const MissionState& state);

// One page of `items`. Tokens are offsets.
template <typename T>
absl::StatusOr<Page<T>> TakePage(std::vector<T> items, const PageRequest& request,
                                 size_t max_page_size) {
  uint64_t offset = 0;
  if (!request.page_token.empty() && !absl::SimpleAtoi(request.page_token, &offset)) {
    return absl::InvalidArgumentError("page_token is not one that the store gave out");
  }
  const size_t size =
      request.page_size == 0 ? max_page_size : std::min(request.page_size, max_page_size);
  const size_t begin = std::min<size_t>(offset, items.size());
  const size_t end = std::min(items.size(), begin + size);
  Page<T> page;
  if (end < items.size()) page.next_page_token = absl::StrCat(end);
  for (size_t i = begin; i < end; ++i) page.items.push_back(std::move(items[i]));
  return page;
}

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ANSWERS_H_
