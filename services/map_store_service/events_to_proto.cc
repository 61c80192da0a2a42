#include "services/map_store_service/events_to_proto.h"

#include <string>
#include <variant>
#include <vector>

#include "absl/time/time.h"
#include "services/convert/agent_report.h"
#include "services/convert/resource_names.h"

namespace corbslam::services {

using map_store::MissionEvent;

namespace {

// Writes each kind of event into its field.
class WhatWriter {
 public:
  WhatWriter(absl::string_view mission, v1::MissionEvent* proto)
      : mission_(mission), proto_(*proto) {}

  void operator()(const MissionEvent::AgentJoined& event) const {
    proto_.mutable_agent_joined()->set_agent(AgentName(mission_, event.agent));
  }
  void operator()(const MissionEvent::AgentLeft& event) const {
    proto_.mutable_agent_left()->set_agent(AgentName(mission_, event.agent));
    proto_.mutable_agent_left()->set_on_purpose(event.on_purpose);
  }
  void operator()(const MissionEvent::LocalMapBegun& event) const {
    auto* begun = proto_.mutable_local_map_begun();
    begun->set_local_map(LocalMapName(mission_, event.local_map));
    begun->set_agent(AgentName(mission_, event.agent));
  }
  void operator()(const MissionEvent::TrackingLost& event) const {
    auto* lost = proto_.mutable_tracking_lost();
    lost->set_local_map(LocalMapName(mission_, event.local_map));
    lost->set_agent(AgentName(mission_, event.agent));
    lost->set_frames(static_cast<uint32_t>(event.frames));
  }
  void operator()(const MissionEvent::MapContradicted& event) const {
    auto* contradicted = proto_.mutable_map_contradicted();
    contradicted->set_agent(AgentName(mission_, event.agent));
    contradicted->set_local_map(LocalMapName(mission_, event.found.local_map));
    contradicted->set_owner(AgentName(mission_, event.owner));
    ToProto(event.found, contradicted->mutable_found());
  }
  void operator()(const MissionEvent::OverlapAccepted& event) const {
    auto* accepted = proto_.mutable_overlap_accepted();
    accepted->set_overlap(OverlapName(mission_, event.overlap));
    accepted->add_local_maps(LocalMapName(mission_, event.query));
    accepted->add_local_maps(LocalMapName(mission_, event.candidate));
  }
  void operator()(const MissionEvent::IslandsMerged& event) const {
    auto* merged = proto_.mutable_islands_merged();
    WriteLocalMaps(event.local_maps, *merged);
    for (const std::string& agent : event.agents) merged->add_agents(AgentName(mission_, agent));
    merged->set_ms(event.ms);
  }
  void operator()(const MissionEvent::LoopClosed& event) const {
    auto* closed = proto_.mutable_loop_closed();
    WriteLocalMaps(event.local_maps, *closed);
    closed->set_overlaps(static_cast<uint32_t>(event.overlaps));
  }
  void operator()(const MissionEvent::MapAdjusted& event) const {
    auto* adjusted = proto_.mutable_map_adjusted();
    adjusted->set_island(LocalMapName(mission_, event.island));
    adjusted->set_keyframes(static_cast<uint32_t>(event.keyframes));
    adjusted->set_map_points(static_cast<uint32_t>(event.map_points));
    adjusted->set_ms(event.ms);
  }
  void operator()(const MissionEvent::OverlapsTakenBack& event) const {
    auto* taken_back = proto_.mutable_overlaps_taken_back();
    for (const uint64_t id : event.overlaps) taken_back->add_overlaps(OverlapName(mission_, id));
  }
  void operator()(const MissionEvent::GlobalLayerForgotten&) const {
    proto_.mutable_global_layer_forgotten();
  }

 private:
  template <typename Message>
  void WriteLocalMaps(const std::vector<LocalMapId>& ids, Message& message) const {
    for (const LocalMapId& id : ids) message.add_local_maps(LocalMapName(mission_, id));
  }

  const absl::string_view mission_;
  v1::MissionEvent& proto_;
};

}  // namespace

void ToProto(absl::string_view mission, const MissionEvent& event, v1::MissionEvent* proto) {
  proto->set_number(event.number);
  proto->set_time_ns(absl::ToUnixNanos(event.time));
  proto->set_revision(event.revision);
  proto->set_missed(event.missed);
  std::visit(WhatWriter(mission, proto), event.what);
}

}  // namespace corbslam::services
