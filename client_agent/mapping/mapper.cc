#include "client_agent/mapping/mapper.h"

#include <glog/logging.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "absl/types/span.h"
#include "client_agent/map/provisional_keyframes.h"
#include "client_agent/mapping/keyframe_insertion.h"
#include "client_agent/mapping/point_creation.h"
#include "client_agent/mapping/point_fusion.h"
#include "slam/optimisation/bundle_scope.h"

namespace corbslam::client_agent {
namespace {

// A map with fewer keyframes has nothing to adjust.
constexpr size_t kMinKeyframesToAdjust = 3;

// Moves keyframes born during an adjustment, and their own points, with the keyframe they hang on,
// which may be another one that was born.
class BornKeyframes {
 public:
  BornKeyframes(const Map& before, Map& map) : before_(before), map_(map) {}

  // Must be called in the order of the keyframes' birth.
  void Move(KeyframeId born) {
    const Keyframe* keyframe = map_.FindKeyframe(born);
    if (keyframe == nullptr) return;
    const Rigid3d old_pose = keyframe->camera_from_map;
    old_poses_[born] = old_pose;
    const Keyframe* parent_now = map_.FindKeyframe(keyframe->parent);
    const std::optional<Rigid3d> parent_before = PoseBefore(keyframe->parent);
    if (parent_now == nullptr || !parent_before.has_value()) return;
    const Rigid3d new_pose = old_pose * parent_before->Inverse() * parent_now->camera_from_map;
    map_.SetPose(born, new_pose);
    MovePoints(born, new_pose.Inverse() * old_pose);
  }

 private:
  std::optional<Rigid3d> PoseBefore(KeyframeId id) const {
    if (const Keyframe* keyframe = before_.FindKeyframe(id)) return keyframe->camera_from_map;
    const auto it = old_poses_.find(id);
    return it == old_poses_.end() ? std::nullopt : std::make_optional(it->second);
  }

  void MovePoints(KeyframeId born, const Rigid3d& new_from_old) {
    const std::vector<MapPointId> points = map_.FindKeyframe(born)->points;
    for (const MapPointId id : points) {
      const MapPoint* point = map_.FindPoint(id);
      if (point == nullptr || before_.FindPoint(id) != nullptr) continue;
      if (point->reference != born) continue;
      map_.SetPosition(id, new_from_old * point->position_in_map);
    }
  }

  const Map& before_;
  Map& map_;
  std::map<KeyframeId, Rigid3d> old_poses_;
};

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
  while (parts_.queue->WaitForWork()) Step();
}

bool Mapper::Step() {
  InsertWaiting();
  std::optional<MappingJob> job;
  if (is_jobs_turn_ || pending_.empty()) job = parts_.queue->TryPopJob();
  if (!job.has_value() && pending_.empty()) return false;
  // Jobs may come as fast as they are done, and so may keyframes: neither waits for all the others.
  is_jobs_turn_ = !job.has_value();
  if (job.has_value()) {
    (*job)(*parts_.map);
  } else {
    MapNextKeyframe();
  }
  if (pending_.empty()) parts_.queue->Done();
  return true;
}

void Mapper::InsertWaiting() {
  while (const std::optional<NewKeyframe> fresh = parts_.queue->TryPopKeyframe()) Insert(*fresh);
}

void Mapper::Insert(const NewKeyframe& keyframe) {
  const KeyframeId id = keyframe.payload->id;
  recent_points_.Add(InsertKeyframe(keyframe, *parts_.map), id);
  if (keyframe.beginning != nullptr) pending_.push_back(keyframe.beginning->first->id);
  pending_.push_back(id);
}

void Mapper::MapNextKeyframe() {
  const KeyframeId id = pending_.front();
  pending_.pop_front();
  MapKeyframe(id);
  if (parts_.on_mapped) parts_.on_mapped(id);
}

void Mapper::MapKeyframe(KeyframeId id) {
  recent_points_.Cull(id, *parts_.map);
  recent_points_.Add(CreatePoints(id, *parts_.map), id);
  // Newer keyframes come first: their points are missed more.
  if (!pending_.empty()) return;
  FuseNeighbours(id, *parts_.map);
  AdjustLocalBundle(id);
  CullKeyframes(id);
  JudgeKeyframes();
  ApplyMeasurements();
}

void Mapper::AdjustLocalBundle(KeyframeId centre) {
  AdjustScope(
      [&](const Map& map) { return LocalBundleScope(map, centre, parts_.map->local_map()); },
      centre);
}

void Mapper::AdjustSince(KeyframeId first) {
  const LocalMapId own = parts_.map->local_map();
  AdjustScope(
      [&](const Map& map) {
        std::vector<KeyframeId> since;
        for (auto it = map.keyframes().lower_bound(first);
             it != map.keyframes().end() && it->first.local_map == own; ++it) {
          since.push_back(it->first);
        }
        const size_t most = std::min(since.size(), kMostTogether);
        return LocalBundleScope(map, absl::MakeConstSpan(since).last(most), own);
      },
      first);
}

void Mapper::AdjustScope(ChooseScope choose, KeyframeId about) {
  const absl::Time start = absl::Now();
  BundleScope scope;
  const Map copy = parts_.map->Read([&](const Map& map) {
    if (map.keyframes().size() < kMinKeyframesToAdjust) return Map();
    scope = choose(map);
    return CopyScope(map, scope);
  });
  if (scope.free_keyframes.empty()) return;
  BundleOptions options = options_.local_bundle;
  // A keyframe born from here on is not in the copy, and moves with its parent when this is
  // committed.
  options.keep_going = [this, &asked = options_.local_bundle.keep_going](double progress) {
    InsertWaiting();
    return !asked || asked(progress);
  };
  const absl::StatusOr<BundleResult> result = AdjustBundle(copy, scope, options);
  if (!result.ok()) {
    LOG(WARNING) << "local bundle adjustment of " << ToString(about) << ": " << result.status();
    return;
  }
  CommitBundle(*result, copy);
  if (parts_.local_ba_ms == nullptr) return;
  parts_.local_ba_ms->Add(absl::ToDoubleMilliseconds(absl::Now() - start));
}

void Mapper::CommitBundle(const BundleResult& result, const Map& before) {
  std::vector<MapPointId> weakened;
  for (const ObservationKey& outlier : result.outliers) weakened.push_back(outlier.point);
  parts_.map->Write([&](Map& map) {
    ApplyBundle(result, map);
    RemoveWeakPoints(weakened, parts_.map->local_map(), map);
    BornKeyframes moved(before, map);
    for (const KeyframeId born : pending_) moved.Move(born);
  });
}

void Mapper::CullKeyframes(KeyframeId centre) {
  const std::vector<KeyframeId> redundant = parts_.map->Read(
      [&](const Map& map) { return FindRedundantKeyframes(map, centre, parts_.map->local_map()); });
  for (const KeyframeId id : redundant) {
    // A keyframe that has not made its own points yet is not to be judged.
    if (std::ranges::find(pending_, id) != pending_.end()) continue;
    const bool removed = parts_.map->Write([&](Map& map) {
      if (!IsRedundant(map, *map.FindKeyframe(id))) return false;
      RemoveKeyframeAndItsPoints(id, map);
      return true;
    });
    if (removed && parts_.on_removed) parts_.on_removed(id);
  }
}

void Mapper::JudgeKeyframes() { TellRemoved(judge_.Judge(*parts_.map)); }

void Mapper::JudgeNewest() { TellRemoved(judge_.JudgeNewest(*parts_.map)); }

void Mapper::TellRemoved(const std::vector<KeyframeId>& removed) const {
  if (!parts_.on_removed) return;
  for (const KeyframeId id : removed) parts_.on_removed(id);
}

// Applies measurements to keyframes that are not provisional any more, because others are told of
// them soon.
void Mapper::ApplyMeasurements() {
  if (parts_.measurements == nullptr) return;
  const KeyframeId last = parts_.map->Read([&](const Map& map) {
    return NewestBut(map, parts_.map->local_map(), kProvisionalKeyframes);
  });
  if (!last.IsValid()) return;
  for (const auto& [id, measurements] : parts_.measurements->TakeUpTo(last)) {
    parts_.map->Write([&, id = id, &measurements = measurements](Map& map) {
      const Keyframe* keyframe = map.FindKeyframe(id);
      if (keyframe == nullptr) return;
      map.SetKeypoints(id, Averaged(keyframe->keypoints(), measurements));
    });
  }
}

}  // namespace corbslam::client_agent
