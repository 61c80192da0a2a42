#include "services/viewer/testing/map_changes.h"

#include <iterator>
#include <utility>

namespace corbslam::testing {
namespace {

constexpr uint32_t kLocalMaps = 5;

template <typename Id>
Id DrawId(LocalMapId local_map, uint32_t index) {
  Id id;
  id.local_map = local_map;
  id.index = index;
  return id;
}

}  // namespace

ChangesWriter::ChangesWriter(uint64_t version) : slots_(changes_.mutable_local_maps()) {
  changes_.set_version(version);
}

v1::WatchMapResponse::Island& ChangesWriter::island() {
  return *changes_.mutable_islands(changes_.islands_size() - 1);
}

ChangesWriter& ChangesWriter::Remove(LocalMapId island) {
  changes_.add_removed_island_slots(slots_.Slot(island));
  return *this;
}

ChangesWriter& ChangesWriter::Island(LocalMapId id, const std::vector<LocalMapId>& local_maps,
                                     bool anew) {
  WriteColumns();
  auto* island = changes_.add_islands();
  island->set_slot(slots_.Slot(id));
  island->set_anew(anew);
  for (const LocalMapId local_map : local_maps) island->add_local_map_slots(slots_.Slot(local_map));
  return *this;
}

ChangesWriter& ChangesWriter::Keyframe(KeyframeId id, double translation) {
  auto* keyframe = island().add_keyframes();
  slots_.Write(id, keyframe->mutable_id());
  for (const double value : {1.0, 0.0, 0.0, 0.0}) {
    keyframe->mutable_camera_from_island()->add_rotation_wxyz(value);
  }
  for (const double value : {translation, 0.0, 0.0}) {
    keyframe->mutable_camera_from_island()->add_translation(value);
  }
  return *this;
}

ChangesWriter& ChangesWriter::RemoveKeyframe(KeyframeId id) {
  slots_.Write(id, island().add_removed_keyframes());
  return *this;
}

ChangesWriter& ChangesWriter::Point(MapPointId id, float x) {
  points_.push_back(id);
  for (const float value : {x, 0.0F, 0.0F}) island().mutable_points()->add_positions(value);
  return *this;
}

ChangesWriter& ChangesWriter::RemovePoint(MapPointId id) {
  removed_points_.push_back(id);
  return *this;
}

void ChangesWriter::WriteColumns() {
  if (!points_.empty()) {
    services::IdColumnWriter ids(slots_, island().mutable_points()->mutable_ids());
    for (const MapPointId& id : points_) ids.Add(id);
  }
  if (!removed_points_.empty()) {
    services::IdColumnWriter ids(slots_, island().mutable_removed_points());
    for (const MapPointId& id : removed_points_) ids.Add(id);
  }
  points_.clear();
  removed_points_.clear();
}

v1::WatchMapResponse ChangesWriter::Take() {
  WriteColumns();
  for (const uint64_t value : changes_.local_maps()) {
    changes_.add_local_map_agents(value == kFirst.value ? "alpha" : "beta");
  }
  return std::move(changes_);
}

v1::WatchMapResponse RandomChanges::Next() {
  ChangesWriter writer(++version_);
  const LocalMapId id{1 + Draw(kLocalMaps)};
  bool is_there = false;
  for (const auto& [island, content] : islands_) is_there |= content.local_maps.contains(id);
  const uint32_t drawn = Draw(10);
  if (!is_there) {
    Begin(id, writer);
  } else if (drawn == 0 && islands_.size() > 1) {
    Merge(writer);
  } else if (drawn == 1) {
    FallApart(writer);
  } else {
    Change(writer);
  }
  return writer.Take();
}

void RandomChanges::TellAll(LocalMapId id, ChangesWriter& writer) {
  const Island& island = islands_[id];
  writer.Island(id, {island.local_maps.begin(), island.local_maps.end()}, true);
  for (const KeyframeId& keyframe : island.keyframes) writer.Keyframe(keyframe, Draw(100));
  for (const MapPointId& point : island.points) writer.Point(point, static_cast<float>(Draw(100)));
}

void RandomChanges::Begin(LocalMapId id, ChangesWriter& writer) {
  islands_[id].local_maps = {id};
  islands_[id].keyframes = {DrawId<KeyframeId>(id, 0)};
  TellAll(id, writer);
}

void RandomChanges::Merge(ChangesWriter& writer) {
  const auto first = islands_.begin();
  const auto second = std::next(first);
  first->second.local_maps.merge(second->second.local_maps);
  first->second.keyframes.merge(second->second.keyframes);
  first->second.points.merge(second->second.points);
  writer.Remove(second->first);
  islands_.erase(second);
  TellAll(first->first, writer);
}

void RandomChanges::FallApart(ChangesWriter& writer) {
  const Island whole = islands_.begin()->second;
  islands_.erase(islands_.begin());
  for (const LocalMapId id : whole.local_maps) {
    islands_[id].local_maps = {id};
    for (const KeyframeId& keyframe : whole.keyframes) {
      if (keyframe.local_map == id) islands_[id].keyframes.insert(keyframe);
    }
    for (const MapPointId& point : whole.points) {
      if (point.local_map == id) islands_[id].points.insert(point);
    }
    TellAll(id, writer);
  }
}

void RandomChanges::Change(ChangesWriter& writer) {
  auto it = islands_.begin();
  std::advance(it, Draw(static_cast<uint32_t>(islands_.size())));
  auto& [id, island] = *it;
  writer.Island(id, {island.local_maps.begin(), island.local_maps.end()}, false);
  for (const LocalMapId local_map : island.local_maps) {
    const KeyframeId keyframe = DrawId<KeyframeId>(local_map, Draw(30));
    island.keyframes.insert(keyframe);
    writer.Keyframe(keyframe, Draw(100));
    const MapPointId point = DrawId<MapPointId>(local_map, Draw(60));
    island.points.insert(point);
    writer.Point(point, static_cast<float>(Draw(100)));
    const KeyframeId gone = DrawId<KeyframeId>(local_map, Draw(30));
    if (gone != keyframe && island.keyframes.erase(gone) > 0) writer.RemoveKeyframe(gone);
    const MapPointId went = DrawId<MapPointId>(local_map, Draw(60));
    if (went != point && island.points.erase(went) > 0) writer.RemovePoint(went);
  }
}

}  // namespace corbslam::testing
