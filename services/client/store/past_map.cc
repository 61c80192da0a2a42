#include "services/client/store/past_map.h"

#include <algorithm>
#include <vector>

#include "services/convert/columns.h"
#include "services/convert/geometry.h"
#include "services/convert/resource_names.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

absl::Status ApplyKeyframes(const v1::WatchMapResponse::Island& changes, const SlotReader& slots,
                            PastMap::Island& island) {
  for (const v1::WatchMapResponse::IslandKeyframe& proto : changes.keyframes()) {
    ASSIGN_OR_RETURN(const KeyframeId id, slots.Keyframe(proto.id()));
    PastMap::Keyframe keyframe;
    if (proto.parent().slot() != 0) {
      ASSIGN_OR_RETURN(keyframe.parent, slots.Keyframe(proto.parent()));
    }
    ASSIGN_OR_RETURN(const Rigid3d camera_from_island, FromProto(proto.camera_from_island()));
    keyframe.island_from_camera = camera_from_island.Inverse();
    island.keyframes[id] = keyframe;
  }
  for (const v1::ItemRef& ref : changes.removed_keyframes()) {
    ASSIGN_OR_RETURN(const KeyframeId id, slots.Keyframe(ref));
    island.keyframes.erase(id);
  }
  return absl::OkStatus();
}

absl::Status ApplyPoints(const v1::WatchMapResponse::Island& changes, const SlotReader& slots,
                         PastMap::Island& island) {
  ASSIGN_OR_RETURN(const std::vector<LightMapPoint> came, ReadLightPoints(changes.points(), slots));
  for (const LightMapPoint& point : came) island.points[point.id] = point.position_in_local;
  ASSIGN_OR_RETURN(const std::vector<MapPointId> went,
                   slots.Points(changes.removed_points(), "removed_points"));
  for (const MapPointId& id : went) island.points.erase(id);
  return absl::OkStatus();
}

}  // namespace

absl::Status PastMap::Apply(const v1::WatchMapResponse& changes) {
  ASSIGN_OR_RETURN(const SlotReader slots, SlotReader::Create(changes.local_maps()));
  const int named = std::min(changes.local_maps_size(), changes.local_map_agents_size());
  for (int i = 0; i < named; ++i) {
    if (changes.local_map_agents(i).empty()) continue;
    agents_[LocalMapId{changes.local_maps(i)}] = LastSegment(changes.local_map_agents(i));
  }
  for (const uint32_t slot : changes.removed_island_slots()) {
    ASSIGN_OR_RETURN(const LocalMapId island, slots.LocalMap(slot));
    islands_.erase(island);
  }
  for (const v1::WatchMapResponse::Island& island : changes.islands()) {
    RETURN_IF_ERROR(ApplyIsland(island, slots));
  }
  revision_ = changes.revision();
  return absl::OkStatus();
}

absl::Status PastMap::ApplyIsland(const v1::WatchMapResponse::Island& changes,
                                  const SlotReader& slots) {
  ASSIGN_OR_RETURN(const LocalMapId id, slots.LocalMap(changes.slot()));
  if (changes.anew()) islands_.erase(id);
  Island& island = islands_[id];
  island.in_global_frame = changes.in_global_frame();
  RETURN_IF_ERROR(ApplyKeyframes(changes, slots, island));
  return ApplyPoints(changes, slots, island);
}

std::string PastMap::AgentOf(LocalMapId local_map) const {
  const auto agent = agents_.find(local_map);
  return agent == agents_.end() ? "" : agent->second;
}

}  // namespace corbslam::services
