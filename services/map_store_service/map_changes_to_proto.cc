#include "services/map_store_service/map_changes_to_proto.h"

#include <map>
#include <span>
#include <string>
#include <utility>

#include "services/convert/geometry.h"
#include "services/convert/ids.h"
#include "services/convert/limits.h"
#include "services/convert/parts.h"

namespace corbslam::services {

using map_store::IslandId;
using map_store::IslandView;
using map_store::MapChanges;

namespace {

constexpr size_t kKeyframeBytes = 140;
constexpr size_t kPointBytes = 30;
constexpr size_t kRefBytes = 16;
constexpr size_t kSlotBytes = 80;
// They come in any number, those of deleted local maps included, of which a part's table takes
// kMaxLocalMapsOfMessage.
constexpr size_t kRemovedIslandBytes = 256;
static_assert(kPartBytes / kRemovedIslandBytes <= kMaxLocalMapsOfMessage);

using Writer = PartWriter<v1::WatchMapResponse>;
using Island = v1::WatchMapResponse::Island;

// Gives the island its message in the part that is being written; if the island began in a part
// before, it is begun again in this one.
class IslandWriter {
 public:
  IslandWriter(const MapChanges::Island& view, Writer& writer) : view_(view), writer_(writer) {}

  Island* InThisPart() {
    if (island_ != nullptr && part_ == &writer_.part()) return island_;
    const bool begins = island_ == nullptr;
    part_ = &writer_.part();
    island_ = part_->add_islands();
    island_->set_slot(writer_.slots().Slot(view_.id));
    island_->set_in_global_frame(view_.is_reference);
    island_->set_anew(begins && view_.anew);
    if (!begins) return island_;
    for (const LocalMapId id : view_.local_maps) {
      island_->add_local_map_slots(writer_.slots().Slot(id));
    }
    return island_;
  }

 private:
  const MapChanges::Island& view_;
  Writer& writer_;
  v1::WatchMapResponse* part_ = nullptr;
  Island* island_ = nullptr;
};

void WriteKeyframes(const MapChanges::Island& view, IslandWriter& islands, Writer& writer) {
  for (const IslandView::KeyframePlace& place : view.keyframes) {
    writer.Reserve(kKeyframeBytes);
    v1::WatchMapResponse::IslandKeyframe* proto = islands.InThisPart()->add_keyframes();
    writer.slots().Write(place.id, proto->mutable_id());
    proto->set_timestamp_ns(place.timestamp_ns);
    ToProto(place.camera_from_island, proto->mutable_camera_from_island());
    if (place.parent.IsValid()) writer.slots().Write(place.parent, proto->mutable_parent());
    proto->set_placed(place.placed);
  }
  for (const KeyframeId& id : view.removed_keyframes) {
    writer.Reserve(kRefBytes);
    writer.slots().Write(id, islands.InThisPart()->add_removed_keyframes());
  }
}

void WritePoints(const MapChanges::Island& view, IslandWriter& islands, Writer& writer) {
  writer.Spread(view.points, kPointBytes, [&](std::span<const IslandView::Point> points) {
    Island& island = *islands.InThisPart();
    v1::LightMapPoints* proto = island.mutable_points();
    IdColumnWriter ids(writer.slots(), proto->mutable_ids());
    for (const IslandView::Point& point : points) {
      ids.Add(point.id);
      for (const double value : point.position_in_island) {
        proto->add_positions(static_cast<float>(value));
      }
      island.add_point_observations(point.observations);
    }
  });
  writer.Spread(view.removed_points, kRefBytes, [&](std::span<const MapPointId> removed) {
    IdColumnWriter ids(writer.slots(), islands.InThisPart()->mutable_removed_points());
    for (const MapPointId& id : removed) ids.Add(id);
  });
}

// Returns how many local maps the islands' items name at most: no mission has more than a table
// takes.
size_t CountNames(const MapChanges& changes) {
  size_t names = 0;
  for (const MapChanges::Island& island : changes.islands) {
    names += 1 + island.local_maps.size() + island.parts.size();
  }
  return names;
}

void WriteRemovedIslands(const MapChanges& changes, Writer& writer) {
  for (const IslandId id : changes.removed_islands) {
    writer.Reserve(kRemovedIslandBytes);
    writer.part().add_removed_island_slots(writer.slots().Slot(id));
  }
  const size_t names = changes.removed_islands.size() + CountNames(changes);
  if (names > kMaxLocalMapsOfMessage) writer.BeginPart();
}

std::map<LocalMapId, std::string> AgentsOf(const MapChanges& changes) {
  std::map<LocalMapId, std::string> agents;
  for (const MapChanges::Island& island : changes.islands) {
    for (size_t i = 0; i < island.local_maps.size(); ++i) {
      agents[island.local_maps[i]] = island.agents[i];
    }
    agents.insert(island.parts.begin(), island.parts.end());
  }
  return agents;
}

}  // namespace

std::vector<v1::WatchMapResponse> ToProto(const MapChanges& changes) {
  Writer writer(kPartBytes, [&](v1::WatchMapResponse& part) {
    part.set_version(changes.version);
    part.set_revision(changes.revision);
    part.set_continues(true);
    return SlotWriter(part.mutable_local_maps());
  });
  WriteRemovedIslands(changes, writer);
  for (const MapChanges::Island& view : changes.islands) {
    writer.Reserve(kSlotBytes * (1 + view.local_maps.size()));
    IslandWriter islands(view, writer);
    islands.InThisPart();
    WriteKeyframes(view, islands, writer);
    WritePoints(view, islands, writer);
  }
  writer.part().set_continues(changes.continues);
  std::vector<v1::WatchMapResponse> parts = std::move(writer).Take();
  const std::map<LocalMapId, std::string> agents = AgentsOf(changes);
  for (v1::WatchMapResponse& part : parts) {
    for (const uint64_t value : part.local_maps()) {
      const auto it = agents.find({value});
      part.add_local_map_agents(it == agents.end() ? std::string() : it->second);
    }
  }
  return parts;
}

}  // namespace corbslam::services
