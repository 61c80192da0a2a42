#include "client_agent/mapping/mapper.h"

#include <glog/logging.h>

#include <utility>

#include "absl/time/clock.h"
#include "client_agent/mapping/keyframe_insertion.h"
#include "client_agent/mapping/point_creation.h"
#include "client_agent/mapping/point_fusion.h"
#include "slam/optimisation/bundle_scope.h"

namespace corbslam {
namespace {

// With fewer there is nothing to adjust.
constexpr size_t kMinKeyframesToAdjust = 3;

// Keyframes born during an adjustment, and their own points, move with the keyframe they hang on.
void MoveBorn(const Map& before, KeyframeId born, Map& map) {
  const Keyframe* keyframe = map.FindKeyframe(born);
  if (keyframe == nullptr) return;
  const Keyframe* parent_now = map.FindKeyframe(keyframe->parent);
  const Keyframe* parent_before = before.FindKeyframe(keyframe->parent);
  if (parent_now == nullptr || parent_before == nullptr) return;
  const Rigid3d old_pose = keyframe->camera_from_map;
  const Rigid3d new_pose =
      old_pose * parent_before->camera_from_map.Inverse() * parent_now->camera_from_map;
  const Rigid3d new_from_old = new_pose.Inverse() * old_pose;
  const std::vector<MapPointId> points = keyframe->points;
  map.SetPose(born, new_pose);
  for (const MapPointId id : points) {
    const MapPoint* point = map.FindPoint(id);
    if (point == nullptr || before.FindPoint(id) != nullptr) continue;
    if (point->reference != born) continue;
    map.SetPosition(id, new_from_old * point->position_in_map);
  }
}

Map CopyScope(const Map& map, const BundleScope& scope) {
  std::vector<KeyframeId> keyframes = scope.free_keyframes;
  keyframes.insert(keyframes.end(), scope.fixed_keyframes.begin(), scope.fixed_keyframes.end());
  std::vector<MapPointId> points = scope.free_points;
  points.insert(points.end(), scope.fixed_points.begin(), scope.fixed_points.end());
  return map.CopyPart(keyframes, points);
}

}  // namespace

Mapper::Mapper(const MapperOptions& options, MapperParts parts)
    : options_(options), parts_(std::move(parts)), recent_points_(parts_.statistics) {}

void Mapper::Run() {
  while (parts_.queue->WaitForItem()) Step();
}

bool Mapper::Step() {
  std::optional<MappingItem> item = parts_.queue->TryPop();
  if (!item.has_value()) return false;
  if (MappingJob* job = std::get_if<MappingJob>(&*item)) {
    (*job)(*parts_.map);
  } else {
    Insert(std::get<NewKeyframe>(*item));
    MapPendingKeyframes();
  }
  parts_.queue->Done();
  return true;
}

void Mapper::Insert(const NewKeyframe& keyframe) {
  const KeyframeId id = keyframe.payload->id;
  recent_points_.Add(InsertKeyframe(keyframe, *parts_.map), id);
  pending_.push_back(id);
}

void Mapper::MapPendingKeyframes() {
  while (!pending_.empty()) {
    const KeyframeId id = pending_.front();
    pending_.pop_front();
    MapKeyframe(id);
    if (parts_.on_mapped) parts_.on_mapped(id);
  }
}

void Mapper::MapKeyframe(KeyframeId id) {
  recent_points_.Cull(id, *parts_.map);
  recent_points_.Add(CreatePoints(id, *parts_.map), id);
  // The newer ones first: their points are missed more.
  if (!pending_.empty()) return;
  FuseNeighbours(id, *parts_.map);
  AdjustLocalBundle(id);
  CullKeyframes(id);
}

void Mapper::AdjustLocalBundle(KeyframeId centre) {
  const absl::Time start = absl::Now();
  BundleScope scope;
  const Map copy = parts_.map->Read([&](const Map& map) {
    if (map.keyframes().size() < kMinKeyframesToAdjust) return Map();
    scope = LocalBundleScope(map, centre, parts_.map->local_map());
    return CopyScope(map, scope);
  });
  if (scope.free_keyframes.empty()) return;
  BundleOptions options = options_.local_bundle;
  options.keep_going = [this](double) {
    // Tracking needs the points of new keyframes at once.
    if (std::optional<NewKeyframe> fresh = parts_.queue->TryPopKeyframe()) Insert(*fresh);
    return true;
  };
  const absl::StatusOr<BundleResult> result = AdjustBundle(copy, scope, options);
  if (!result.ok()) {
    LOG(WARNING) << "local bundle adjustment of " << ToString(centre) << ": " << result.status();
    return;
  }
  CommitBundle(*result, copy);
  absl::MutexLock lock(&mutex_);
  local_ba_ms_.push_back(absl::ToDoubleMilliseconds(absl::Now() - start));
}

void Mapper::CommitBundle(const BundleResult& result, const Map& before) {
  std::vector<MapPointId> weakened;
  for (const ObservationKey& outlier : result.outliers) weakened.push_back(outlier.point);
  parts_.map->Write([&](Map& map) {
    ApplyBundle(result, map);
    RemoveWeakPoints(weakened, parts_.map->local_map(), map);
    for (const KeyframeId born : pending_) MoveBorn(before, born, map);
  });
}

void Mapper::CullKeyframes(KeyframeId centre) {
  const std::vector<KeyframeId> redundant = parts_.map->Read(
      [&](const Map& map) { return FindRedundantKeyframes(map, centre, parts_.map->local_map()); });
  for (const KeyframeId id : redundant) {
    const bool removed = parts_.map->Write([&](Map& map) {
      if (!IsRedundant(map, *map.FindKeyframe(id))) return false;
      RemoveKeyframeAndItsPoints(id, map);
      return true;
    });
    if (removed && parts_.on_removed) parts_.on_removed(id);
  }
}

std::vector<double> Mapper::local_ba_ms() const {
  absl::MutexLock lock(&mutex_);
  return local_ba_ms_;
}

}  // namespace corbslam
