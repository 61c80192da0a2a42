// What happened in a mission, one thing after the other, for people and alerts.
#ifndef CORBSLAM_MAP_STORE_STATE_MISSION_EVENT_H_
#define CORBSLAM_MAP_STORE_STATE_MISSION_EVENT_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "absl/time/time.h"
#include "map_store/state/lookups.h"
#include "slam/exchange/agent_report.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// One thing that happened. The journal has none, so that a replay makes none.
struct MissionEvent {
  // An agent opened a session.
  struct AgentJoined {
    std::string agent;
  };
  // An agent's session ended, and no other one took its place.
  struct AgentLeft {
    std::string agent;
    bool on_purpose = false;  // It ended the session itself; false: the line broke.
  };
  // The first batch of a local map came.
  struct LocalMapBegun {
    LocalMapId local_map;
    std::string agent;
  };
  // A batch reported so many frames of an agent that had not been lost until then.
  struct TrackingLost {
    LocalMapId local_map;
    std::string agent;
    size_t frames = 0;
  };
  // An agent goes without another one's local map from now on.
  struct MapContradicted {
    std::string agent;
    std::string owner;  // Of the local map.
    MapContradiction found;
  };
  // A worker verified a place that keyframes of these two local maps saw, and accepted it.
  struct OverlapAccepted {
    uint64_t overlap = 0;
    LocalMapId query;
    LocalMapId candidate;
  };
  // Islands became this one.
  struct IslandsMerged {
    std::vector<LocalMapId> local_maps;  // The first one names the island.
    std::vector<std::string> agents;     // Their owners, each once.
    double ms = 0;                       // From the verified overlap to the committed revision.
  };
  // An island was welded where it meets itself.
  struct LoopClosed {
    std::vector<LocalMapId> local_maps;  // Those whose keyframes were joined, each once.
    size_t overlaps = 0;                 // The number that was taken into the graph.
  };
  // Bundle adjustment of an island was committed.
  struct MapAdjusted {
    IslandId island;
    // How many of its keyframes and points were adjusted.
    size_t keyframes = 0;
    size_t map_points = 0;
    double ms = 0;  // From the snapshot to the committed revision.
  };
  // Somebody took back these overlaps.
  struct OverlapsTakenBack {
    std::vector<uint64_t> overlaps;
  };
  // Somebody had all that fusion found forgotten.
  struct GlobalLayerForgotten {};

  using What = std::variant<AgentJoined, AgentLeft, LocalMapBegun, TrackingLost, MapContradicted,
                            OverlapAccepted, IslandsMerged, LoopClosed, MapAdjusted,
                            OverlapsTakenBack, GlobalLayerForgotten>;

  uint64_t number = 0;  // Grows by one with each event of the mission, from 1 on.
  absl::Time time;
  uint64_t revision = 0;  // The mission's, once it had happened.
  uint64_t missed = 0;    // So many events before this one are forgotten, and were not told.
  What what;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_MISSION_EVENT_H_
