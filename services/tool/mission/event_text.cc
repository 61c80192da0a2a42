#include "services/tool/mission/event_text.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "services/convert/agent_report.h"
#include "services/convert/resource_names.h"

namespace corbslam::services {
namespace {

using Event = v1::MissionEvent;
using Names = google::protobuf::RepeatedPtrField<std::string>;

std::string ShortName(const std::string& local_map, const LocalMapNames& names) {
  const auto name = names.find(local_map);
  return name == names.end() ? LastSegment(local_map) : name->second;
}

std::string Join(const Names& local_maps, const LocalMapNames& names) {
  return absl::StrJoin(local_maps, " and ", [&](std::string* out, const std::string& local_map) {
    absl::StrAppend(out, ShortName(local_map, names));
  });
}

std::string JoinOverlaps(const Names& overlaps) {
  return absl::StrJoin(overlaps, ", ", [](std::string* out, const std::string& overlap) {
    absl::StrAppend(out, LastSegment(overlap));
  });
}

std::string DescribeContradicted(const Event::MapContradicted& event, const LocalMapNames& names) {
  return absl::StrCat(LastSegment(event.agent()), " goes without ",
                      ShortName(event.local_map(), names), ", which is ",
                      DescribeContradiction(event.found()));
}

std::string DescribeLoop(const Event::LoopClosed& loop, const LocalMapNames& names) {
  if (loop.overlaps() == 0) {
    return absl::StrCat("the owner of ", Join(loop.local_maps(), names), " closed a loop");
  }
  return absl::StrCat("a loop was closed in ", Join(loop.local_maps(), names), " by ",
                      loop.overlaps(), loop.overlaps() == 1 ? " overlap" : " overlaps");
}

std::string DescribeAdjustment(const Event::MapAdjusted& adjusted, const LocalMapNames& names) {
  return absl::StrFormat("the island of %s was adjusted: %u keyframes, %u points (%.0f ms)",
                         ShortName(adjusted.island(), names), adjusted.keyframes(),
                         adjusted.map_points(), adjusted.ms());
}

std::string DescribeFusion(const Event& event, const LocalMapNames& names) {
  switch (event.event_case()) {
    case Event::kOverlapAccepted:
      return absl::StrCat("overlap ", LastSegment(event.overlap_accepted().overlap()), " between ",
                          Join(event.overlap_accepted().local_maps(), names), " was accepted");
    case Event::kIslandsMerged:
      return absl::StrFormat("%s are one island (%.0f ms)",
                             Join(event.islands_merged().local_maps(), names),
                             event.islands_merged().ms());
    case Event::kLoopClosed:
      return DescribeLoop(event.loop_closed(), names);
    case Event::kMapAdjusted:
      return DescribeAdjustment(event.map_adjusted(), names);
    case Event::kOverlapsTakenBack:
      return absl::StrCat("somebody took back overlap ",
                          JoinOverlaps(event.overlaps_taken_back().overlaps()));
    case Event::kGlobalLayerForgotten:
      return "somebody had all that fusion found forgotten";
    default:
      return "something that this program does not know";
  }
}

}  // namespace

std::string DescribeContradiction(const v1::MapContradiction& found) {
  const absl::StatusOr<MapContradiction> read = FromProto(found);
  return read.ok() ? Describe(*read) : read.status().ToString();
}

std::string DescribeEvent(const Event& event, const LocalMapNames& names) {
  switch (event.event_case()) {
    case Event::kAgentJoined:
      return absl::StrCat(LastSegment(event.agent_joined().agent()), " joined");
    case Event::kAgentLeft:
      return absl::StrCat(LastSegment(event.agent_left().agent()), event.agent_left().on_purpose()
                                                                       ? " ended its session"
                                                                       : " left: its line broke");
    case Event::kLocalMapBegun:
      return absl::StrCat(LastSegment(event.local_map_begun().agent()), " began local map ",
                          ShortName(event.local_map_begun().local_map(), names));
    case Event::kTrackingLost:
      return absl::StrCat(LastSegment(event.tracking_lost().agent()),
                          " did not know where it was, for ", event.tracking_lost().frames(),
                          event.tracking_lost().frames() == 1 ? " frame" : " frames");
    case Event::kMapContradicted:
      return DescribeContradicted(event.map_contradicted(), names);
    default:
      return DescribeFusion(event, names);
  }
}

bool IsWarning(const Event& event) {
  return event.has_tracking_lost() || event.has_map_contradicted() ||
         event.has_overlaps_taken_back() || event.has_global_layer_forgotten();
}

}  // namespace corbslam::services
