// Makes the answers to look-ups from a mission's state.
#ifndef CORBSLAM_MAP_STORE_VIEW_ANSWERS_H_
#define CORBSLAM_MAP_STORE_VIEW_ANSWERS_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "map_store/state/lookups.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Returns NOT_FOUND, naming the local map.
absl::Status NoSuchLocalMap(LocalMapId id);

MissionInfo DescribeMission(const MissionState& state);
AgentInfo DescribeAgent(const MissionState& state, const std::string& name,
                        const AgentState& agent);
LocalMapInfo DescribeLocalMap(const MissionState& state, const LocalMapState& local_map);
// Describes the keyframes one after the other; the state must have all of them.
std::vector<KeyframeInfo> DescribeKeyframes(const MissionState& state,
                                            const std::vector<KeyframeId>& ids);
MissionStatistics DescribeStatistics(const MissionState& state);
OverlapInfo DescribeOverlap(const MissionState& state, const OverlapEntry& entry);
// A local map's overlaps are also those of its parts, by whatever of their names it is asked for.
bool Matches(const OverlapFilter& filter, const Overlap& overlap, const MissionState& state);
IslandView DescribeIsland(const MissionState& state, const Island& island);
// Returns the reference island first, the others by id.
std::vector<const Island*> OrderedIslands(const MissionState& state);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_ANSWERS_H_
