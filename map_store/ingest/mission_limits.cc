#include "map_store/ingest/mission_limits.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "map_store/ingest/quota.h"
#include "map_store/view/memory_estimate.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// What is held against a limit.
struct Amount {
  std::string whose;
  std::string limit_name;  // As the mission's message has it.
  absl::string_view unit;
  uint64_t there = 0;
  uint64_t more = 0;
  uint64_t limit = 0;  // 0: there is none.
};

// `what` is it that wants more.
absl::Status CheckAmount(const Amount& amount, const std::string& what) {
  if (amount.limit == 0) return absl::OkStatus();
  if (amount.there <= amount.limit && amount.more <= amount.limit - amount.there) {
    return absl::OkStatus();
  }
  return absl::ResourceExhaustedError(
      absl::StrCat(amount.whose, " has ", amount.there, " ", amount.unit, "; ", what, " has ",
                   amount.more, " more; the limit ", amount.limit_name, " of the mission is ",
                   amount.limit, " (`corbslam mission set` changes it)"));
}

// Estimates what is there only where there is a limit.
absl::Status CheckMemory(const MissionState& state, uint64_t more, const std::string& what) {
  const uint64_t limit = state.profile.limits.memory_bytes;
  if (limit == 0) return absl::OkStatus();
  return CheckAmount({absl::StrCat("mission ", state.name), "limits.memory_bytes",
                      "bytes in memory", EstimateMemory(state), more, limit},
                     what);
}

uint64_t CountNewKeyframes(const LocalMapState* local_map, const MapUpdateBatch& batch) {
  return static_cast<uint64_t>(
      std::ranges::count_if(batch.full_keyframes, [local_map](const FullKeyframe& keyframe) {
        // The batch is not validated yet.
        return keyframe.payload != nullptr &&
               (local_map == nullptr || !local_map->arrival.contains(keyframe.payload->id));
      }));
}

}  // namespace

std::string NameOfBatch(const MapUpdateBatch& batch) {
  return absl::StrCat("batch ", batch.number, " of local map ", ToString(batch.local_map));
}

std::string NameOfPart(const LocalisedFrames& part) {
  return absl::StrCat("part ", part.number, " of run ", ToString(LocalMapId{part.run}));
}

absl::Status CheckKeyframeLimits(const MissionState& state, const std::string& agent,
                                 const MapUpdateBatch& batch) {
  const MissionProfile& profile = state.profile;
  const auto own = profile.agent_limits.find(agent);
  const uint64_t own_limit = own == profile.agent_limits.end() ? 0 : own->second.keyframes;
  if (profile.limits.keyframes == 0 && own_limit == 0) return absl::OkStatus();
  const uint64_t more = CountNewKeyframes(state.FindLocalMap(batch.local_map), batch);
  if (more == 0) return absl::OkStatus();
  uint64_t of_mission = 0;
  uint64_t of_agent = 0;
  for (const auto& [id, local_map] : state.local_maps) {
    const size_t keyframes = local_map.map.keyframes().size();
    of_mission += keyframes;
    if (local_map.agent == agent) of_agent += keyframes;
  }
  RETURN_IF_ERROR(CheckAmount(
      {absl::StrCat("agent ", agent, " of mission ", state.name),
       absl::StrCat("agent_limits[", agent, "].keyframes"), "keyframes", of_agent, more, own_limit},
      NameOfBatch(batch)));
  return CheckAmount({absl::StrCat("mission ", state.name), "limits.keyframes", "keyframes",
                      of_mission, more, profile.limits.keyframes},
                     NameOfBatch(batch));
}

absl::Status CheckMemoryLimit(const MissionState& state, const MapUpdateBatch& batch) {
  const bool adds = !batch.full_keyframes.empty() || !batch.full_points.empty();
  if (!adds) return absl::OkStatus();
  return CheckMemory(state, 2 * StoredBytes(batch), NameOfBatch(batch));
}

absl::Status CheckMemoryLimit(const MissionState& state, const LocalisedFrames& part) {
  if (part.tracked_frames.empty()) return absl::OkStatus();
  return CheckMemory(state, StoredBytes(part), NameOfPart(part));
}

absl::Status CheckDiskLimit(const std::string& mission, uint64_t disk_bytes, uint64_t limit_bytes,
                            const std::string& what, uint64_t bytes) {
  return CheckAmount({absl::StrCat("mission ", mission), "limits.disk_bytes", "bytes on disk",
                      disk_bytes, bytes, limit_bytes},
                     what);
}

size_t CountLimitedLocalMaps(const MissionState& state) {
  return static_cast<size_t>(std::ranges::count_if(state.local_maps, [&state](const auto& item) {
    const Island* island = state.FindIslandOf(item.first);
    const bool is_joined = island != nullptr && island->local_maps.size() > 1;
    return !item.second.closed || !is_joined;
  }));
}

namespace {

// Returns how many names messages may have to tell: of local maps, of those that have become parts
// of others, which keep theirs, and of islands whose own local map was deleted.
size_t CountNames(const MissionState& state) {
  const auto orphans = std::ranges::count_if(state.global.islands, [&state](const auto& item) {
    return state.FindLocalMap(item.first) == nullptr;
  });
  return state.local_maps.size() + state.joined_into.size() + static_cast<size_t>(orphans);
}

// Checks with so many local maps more.
absl::Status CheckLocalMapsAnd(size_t more, const MissionState& state,
                               const MapStoreOptions& options) {
  const size_t all = state.local_maps.size() + state.joined_into.size();
  // What is there already stays, as of the time before these names counted.
  const size_t names = more > 0 ? CountNames(state) : all;
  if (names + more > kMaxLocalMapsInAll) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "mission ", state.name, " has ", all, " local maps",
        names > all ? absl::StrCat(" and ", names - all, " islands named after deleted ones") : "",
        "; no mission has more than ", kMaxLocalMapsInAll,
        ": delete a robot's old ones (`corbslam mission forget`), or begin another one"));
  }
  const size_t counted = CountLimitedLocalMaps(state);
  if (counted + more <= options.max_local_maps_per_mission) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("mission ", state.name, " has ", counted,
                   " local maps that are open, or were not joined ", "with another one, of ", all,
                   "; the limit is ", options.max_local_maps_per_mission, " (--max-local-maps)"));
}

}  // namespace

absl::Status CheckRoomForLocalMap(const MissionState& state, const MapStoreOptions& options) {
  return CheckLocalMapsAnd(1, state, options);
}

absl::Status CheckLocalMaps(const MissionState& state, const MapStoreOptions& options) {
  return CheckLocalMapsAnd(0, state, options);
}

}  // namespace corbslam::map_store
