#include "map_store/records/state_validation.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>

#include "absl/strings/str_cat.h"
#include "map_store/ingest/batch_validation.h"
#include "map_store/state/mission_uid.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

absl::Status Check(bool sound, absl::string_view what) {
  return sound ? absl::OkStatus() : absl::DataLossError(absl::StrCat(what, " is damaged"));
}

bool IsKnown(const MissionState& state, LocalMapId id) { return state.FindLocalMap(id) != nullptr; }

template <typename Id>
bool IsOf(const LocalMapState& local_map, Id id) {
  return id.IsValid() && local_map.IsNamed(id.local_map);
}

// Returns whether every keyframe has its place in the order of arrival.
bool IsArrivalSound(const LocalMapState& local_map) {
  if (local_map.arrival.size() != local_map.arrived.size()) return false;
  for (size_t i = 0; i < local_map.arrived.size(); ++i) {
    const auto it = local_map.arrival.find(local_map.arrived[i]);
    if (it == local_map.arrival.end() || it->second != i) return false;
  }
  return local_map.settled <= local_map.arrived.size() &&
         std::ranges::all_of(local_map.map.keyframes(), [&local_map](const auto& item) {
           return IsOf(local_map, item.first) && local_map.arrival.contains(item.first);
         });
}

bool AreForeignObservationsSound(const LocalMapState& local_map) {
  return std::ranges::all_of(local_map.foreign_observations, [&local_map](const auto& seen) {
    const Keyframe* keyframe = local_map.map.FindKeyframe(seen.first);
    // The observations are sorted by keypoint, so that the last has the largest.
    return keyframe != nullptr &&
           (seen.second.empty() || seen.second.rbegin()->first < keyframe->points.size());
  });
}

// Returns whether the frames of the parts stand one behind the other.
bool AreSessionsSound(const LocalMapState& local_map) {
  uint64_t frame = 0;
  uint64_t lost = 0;
  for (const JoinedLocalMap& part : local_map.joined) {
    if (part.first_frame < frame || part.first_lost_frame < lost) return false;
    frame = part.first_frame;
    lost = part.first_lost_frame;
  }
  return frame <= local_map.frames.size() && lost <= local_map.lost_frames_ns.size();
}

// Returns whether no two local maps, parts and deleted ones included, have one name.
bool AreNamesSound(const MissionState& state) {
  std::set<LocalMapId> names;
  size_t named = 0;
  for (const auto& [id, local_map] : state.local_maps) {
    for (const LocalMapId& name : local_map.Names()) {
      ++named;
      names.insert(name);
    }
  }
  return names.size() == named && std::ranges::none_of(names, [&state](LocalMapId name) {
           return state.forgotten.contains(name);
         });
}

// Returns whether each of these names arrived, once.
bool AreArrivalsSound(const MissionState& state) {
  std::set<LocalMapId> arrived;
  for (const auto& [number, name] : state.arrivals.names()) {
    if (!arrived.insert(name).second) return false;
  }
  return std::ranges::all_of(state.local_maps, [&arrived](const auto& item) {
    return std::ranges::all_of(item.second.Names(),
                               [&arrived](LocalMapId name) { return arrived.contains(name); });
  });
}

// Returns whether no name has numbers of two agents, and every name that is there has one of its
// own agent.
bool AreNumbersSound(const MissionState& state) {
  std::map<LocalMapId, std::string> agents;
  for (const auto& [agent, names] : state.arrivals.of_agents()) {
    for (const LocalMapId& name : names) {
      if (!agents.emplace(name, agent).second) return false;
    }
  }
  return std::ranges::all_of(state.local_maps, [&agents](const auto& item) {
    return std::ranges::all_of(item.second.Names(), [&](LocalMapId name) {
      const auto agent = agents.find(name);
      return agent != agents.end() && agent->second == item.second.agent;
    });
  });
}

absl::Status ValidateLocalMap(const LocalMapState& local_map) {
  const std::string what = absl::StrCat("local map ", ToString(local_map.id));
  RETURN_IF_ERROR(Check(IsArrivalSound(local_map), absl::StrCat(what, ": its order")));
  RETURN_IF_ERROR(Check(AreSessionsSound(local_map), absl::StrCat(what, ": its parts")));
  RETURN_IF_ERROR(Check(AreForeignObservationsSound(local_map),
                        absl::StrCat(what, ": what it sees of others' points")));
  const bool own_points =
      std::ranges::all_of(local_map.map.points(),
                          [&local_map](const auto& item) { return IsOf(local_map, item.first); });
  return Check(own_points, absl::StrCat(what, ": whose points it has"));
}

bool IsTrackSound(const LocalisedTrack& track) {
  std::set<uint64_t> ids;
  return std::ranges::all_of(track.runs, [&ids](const LocalisedRun& run) {
    return run.id != 0 && run.last_number != 0 && ids.insert(run.id).second &&
           std::ranges::all_of(run.frames,
                               [](const TrackedFrame& frame) { return frame.reference.IsValid(); });
  });
}

// Checks that each local map is one agent's, and that each agent's local maps are there.
absl::Status ValidateAgents(const MissionState& state) {
  size_t owned = 0;
  for (const auto& [name, agent] : state.agents) {
    RETURN_IF_ERROR(Check(ValidateName("agent", name).ok(), "an agent's name"));
    RETURN_IF_ERROR(
        Check(IsTrackSound(agent.track), absl::StrCat("agent ", name, ": where it localised")));
    for (const LocalMapId& id : agent.local_maps) {
      const LocalMapState* local_map = state.FindLocalMap(id);
      RETURN_IF_ERROR(Check(local_map != nullptr && local_map->agent == name,
                            absl::StrCat("agent ", name, ": its list of local maps")));
    }
    owned += agent.local_maps.size();
  }
  return Check(owned == state.local_maps.size(), "whose local maps are whose");
}

// Checks that every local map lies in one island.
absl::Status ValidateIslands(const MissionState& state) {
  size_t members = 0;
  for (const auto& [id, island] : state.global.islands) {
    bool sound = island.id == id && !island.local_maps.empty();
    for (const LocalMapId& member : island.local_maps) {
      const auto it = state.global.island_of.find(member);
      sound =
          sound && IsKnown(state, member) && it != state.global.island_of.end() && it->second == id;
    }
    for (const LocalMapId& relaxed : island.relaxed) sound = sound && IsKnown(state, relaxed);
    for (const KeyframeId& id : island.displaced) sound = sound && IsKnown(state, id.local_map);
    RETURN_IF_ERROR(Check(sound, absl::StrCat("island ", ToString(id))));
    members += island.local_maps.size();
  }
  for (const auto& [part, whole] : state.joined_into) {
    const auto it = state.global.island_of.find(part);
    RETURN_IF_ERROR(
        Check(it != state.global.island_of.end() && it->second == state.global.island_of.at(whole),
              absl::StrCat("what local map ", ToString(part), " is a part of")));
  }
  return Check(members == state.order.size() &&
                   state.global.island_of.size() == members + state.joined_into.size(),
               "which island has which local map");
}

// Checks that landmarks are of living points, all in one island.
absl::Status ValidateLandmarks(const MissionState& state) {
  for (const auto& [survivor, points] : state.global.landmarks.sets()) {
    const Island* island = state.FindIslandOf(survivor.local_map);
    bool sound = island != nullptr && state.FindPoint(survivor) != nullptr;
    for (const MapPointId& point : points) {
      sound = sound && state.FindPoint(point) != nullptr &&
              state.FindIslandOf(point.local_map) == island;
    }
    RETURN_IF_ERROR(Check(sound, absl::StrCat("the landmark of point ", ToString(survivor))));
  }
  return absl::OkStatus();
}

absl::Status ValidateOverlaps(const MissionState& state) {
  for (const auto& [id, entry] : state.global.overlaps.entries()) {
    const bool sound = entry.id == id && id < state.next_overlap &&
                       IsKnown(state, entry.overlap.query.local_map) &&
                       IsKnown(state, entry.overlap.candidate.local_map);
    RETURN_IF_ERROR(Check(sound, absl::StrCat("overlap ", id)));
  }
  const bool queries =
      std::ranges::all_of(state.queries.ToTasks(), [&state](const QueryTask& task) {
        return IsKnown(state, task.query.local_map) && IsKnown(state, task.against);
      });
  return Check(queries, "the queue of queries");
}

absl::Status ValidatePlaces(const MissionState& state) {
  const auto known = [&state](const auto& item) { return IsKnown(state, item.first.local_map); };
  const bool places = std::ranges::all_of(state.global.keyframes, known) &&
                      std::ranges::all_of(state.global.points, known);
  RETURN_IF_ERROR(Check(places, "what fusion placed"));
  const bool anchors = std::ranges::all_of(state.global.points, [&state](const auto& item) {
    return IsKnown(state, item.second.anchor.local_map);
  });
  RETURN_IF_ERROR(Check(anchors, "what fusion's points are anchored in"));
  const bool culled = std::ranges::all_of(
      state.global.culled, [&state](KeyframeId id) { return IsKnown(state, id.local_map); });
  RETURN_IF_ERROR(Check(culled, "what fusion culled"));
  const bool stand_ins = std::ranges::all_of(state.global.stand_ins, [&state](const auto& item) {
    return IsKnown(state, item.first.local_map) && IsKnown(state, item.second.keyframe.local_map) &&
           state.FindIslandOf(item.first.local_map) ==
               state.FindIslandOf(item.second.keyframe.local_map);
  });
  RETURN_IF_ERROR(Check(stand_ins, "what stands in for retired keyframes"));
  const bool rejected = std::ranges::all_of(state.global.rejected,
                                            [](const auto& item) { return item.second.IsValid(); });
  return Check(rejected, "what fusion rejected");
}

}  // namespace

absl::Status ValidateState(const MissionState& state) {
  bool ordered = state.order.size() == state.local_maps.size();
  for (size_t i = 0; i < state.order.size(); ++i) {
    const LocalMapState* local_map = state.FindLocalMap(state.order[i]);
    ordered = ordered && local_map != nullptr && local_map->order == i;
  }
  RETURN_IF_ERROR(Check(ordered, "the order of local maps"));
  RETURN_IF_ERROR(Check(AreNamesSound(state), "what names local maps have"));
  RETURN_IF_ERROR(Check(AreArrivalsSound(state), "when local maps arrived"));
  RETURN_IF_ERROR(Check(AreNumbersSound(state), "which of their agents' local maps they are"));
  if (const absl::Status profile = ValidateProfile(state.profile); !profile.ok()) {
    return absl::DataLossError(absl::StrCat("the mission's profile: ", profile.message()));
  }
  RETURN_IF_ERROR(Check(state.uid.empty() || IsMissionUid(state.uid), "the mission's uid"));
  for (const auto& [id, local_map] : state.local_maps) RETURN_IF_ERROR(ValidateLocalMap(local_map));
  RETURN_IF_ERROR(ValidateAgents(state));
  RETURN_IF_ERROR(ValidateIslands(state));
  RETURN_IF_ERROR(ValidateLandmarks(state));
  RETURN_IF_ERROR(ValidateOverlaps(state));
  return ValidatePlaces(state);
}

}  // namespace corbslam::map_store
