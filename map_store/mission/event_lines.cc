#include "map_store/mission/event_lines.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"

namespace corbslam::map_store {
namespace {

std::string AgentFields(const std::string& mission, const std::string& agent) {
  return absl::StrCat("mission=", mission, " agent=", agent, " ");
}

std::string JoinMaps(const std::vector<LocalMapId>& local_maps) {
  return absl::StrJoin(local_maps, ", ", [](std::string* out, LocalMapId local_map) {
    absl::StrAppend(out, ToString(local_map));
  });
}

}  // namespace

std::optional<std::string> LineOf(const std::string& mission, const MissionEvent::What& what) {
  if (const auto* begun = std::get_if<MissionEvent::LocalMapBegun>(&what)) {
    return absl::StrCat(AgentFields(mission, begun->agent), "local map ",
                        ToString(begun->local_map), " begins");
  }
  if (const auto* lost = std::get_if<MissionEvent::TrackingLost>(&what)) {
    return absl::StrCat(AgentFields(mission, lost->agent), "lost: ", lost->frames,
                        lost->frames == 1 ? " frame" : " frames", " of local map ",
                        ToString(lost->local_map), " without a pose");
  }
  if (const auto* contradicted = std::get_if<MissionEvent::MapContradicted>(&what)) {
    return absl::StrCat(AgentFields(mission, contradicted->agent), "goes without local map ",
                        ToString(contradicted->found.local_map), " of ", contradicted->owner,
                        ", which is ", Describe(contradicted->found));
  }
  if (const auto* merged = std::get_if<MissionEvent::IslandsMerged>(&what)) {
    return absl::StrFormat("mission=%s merged: the maps of %s are in one frame (%s), after %.0f ms",
                           mission, absl::StrJoin(merged->agents, ", "),
                           JoinMaps(merged->local_maps), merged->ms);
  }
  return std::nullopt;
}

}  // namespace corbslam::map_store
