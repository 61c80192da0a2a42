#include "services/client/store/told_map.h"

#include <algorithm>
#include <vector>

#include "services/convert/columns.h"
#include "services/convert/geometry.h"
#include "services/convert/resource_names.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

using ProtoIsland = v1::WatchMapResponse::Island;
using ProtoKeyframe = v1::WatchMapResponse::IslandKeyframe;

absl::Status ApplyKeyframes(const ProtoIsland& changes, const SlotReader& slots,
                            ToldMap::Island& island) {
  for (const ProtoKeyframe& proto : changes.keyframes()) {
    ASSIGN_OR_RETURN(const KeyframeId id, slots.Keyframe(proto.id()));
    ToldMap::Keyframe keyframe;
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

absl::Status ApplyPoints(const ProtoIsland& changes, const SlotReader& slots,
                         ToldMap::Island& island) {
  ASSIGN_OR_RETURN(const std::vector<LightMapPoint> points,
                   ReadLightPoints(changes.points(), slots));
  for (const LightMapPoint& point : points) {
    island.points[point.id] = point.position_in_local.cast<float>();
  }
  ASSIGN_OR_RETURN(const std::vector<MapPointId> went,
                   slots.Points(changes.removed_points(), "removed_points"));
  for (const MapPointId& id : went) island.points.erase(id);
  return absl::OkStatus();
}

}  // namespace

absl::Status ToldMap::ApplyIsland(const ProtoIsland& changes, const SlotReader& slots) {
  ASSIGN_OR_RETURN(const LocalMapId id, slots.LocalMap(changes.slot()));
  Island& island = islands[id];
  if (changes.anew()) island = Island();
  island.in_global_frame = changes.in_global_frame();
  RETURN_IF_ERROR(ApplyKeyframes(changes, slots, island));
  return ApplyPoints(changes, slots, island);
}

absl::Status ToldMap::Apply(const v1::WatchMapResponse& changes) {
  ASSIGN_OR_RETURN(const SlotReader slots, SlotReader::Create(changes.local_maps()));
  const int known = std::min(changes.local_maps_size(), changes.local_map_agents_size());
  for (int i = 0; i < known; ++i) {
    const std::string agent = LastSegment(changes.local_map_agents(i));
    if (!agent.empty()) agents[LocalMapId{changes.local_maps(i)}] = agent;
  }
  for (const uint32_t slot : changes.removed_island_slots()) {
    ASSIGN_OR_RETURN(const LocalMapId id, slots.LocalMap(slot));
    islands.erase(id);
  }
  for (const ProtoIsland& island : changes.islands()) {
    RETURN_IF_ERROR(ApplyIsland(island, slots));
  }
  version = changes.version();
  revision = changes.revision();
  return absl::OkStatus();
}

std::string ToldMap::AgentOf(LocalMapId local_map) const {
  const auto agent = agents.find(local_map);
  return agent == agents.end() ? std::string() : agent->second;
}

size_t ToldMap::CountKeyframes() const {
  size_t count = 0;
  for (const auto& [id, island] : islands) count += island.keyframes.size();
  return count;
}

}  // namespace corbslam::services
