#include "client_agent/mapping/culling.h"

#include <utility>

#include "client_agent/mapping/keyframe_insertion.h"

namespace corbslam::client_agent {
namespace {

constexpr double kMinFoundRatio = 0.25;
// Observations with depth count twice: three are one keyframe with depth and one without, two are
// one with depth. Without depths two are the keyframes that located the point.
constexpr int kTooFewObservations = 3;
constexpr int kTooFewWithoutDepth = 2;
constexpr int kWeakObservations = 2;
constexpr uint32_t kAgeToBeSeen = 2;
constexpr uint32_t kAgeToBeKept = 3;
constexpr int kEnoughOthers = 3;

// Without a baseline every point counts.
bool IsClose(const Keyframe& keyframe, const Keypoint& keypoint) {
  const Camera& camera = keyframe.camera();
  return !camera.IsMetric() ||
         keypoint.disparity_px >= DisparityFromDepth(camera, camera.close_depth_m);
}

// Those of the camera that the point was first seen by.
int TooFewObservations(const Map& map, const MapPoint& point) {
  const Keyframe* keyframe = map.FindKeyframe(point.reference);
  const bool has_depths = keyframe == nullptr || keyframe->camera().IsMetric();
  return has_depths ? kTooFewObservations : kTooFewWithoutDepth;
}

bool AreOf(Viewers viewers, KeyframeId other, KeyframeId keyframe) {
  if (viewers == Viewers::kOthers) return other.local_map != keyframe.local_map;
  return other != keyframe && other.local_map == keyframe.local_map;
}

}  // namespace

void RecentPoints::Add(const std::vector<MapPointId>& points, KeyframeId made_at) {
  for (const MapPointId id : points) {
    statistics_->Watch(id);
    recent_.push_back({id, made_at.index});
  }
}

RecentPoints::Verdict RecentPoints::Judge(const Map& map, const Recent& recent,
                                          uint32_t newest) const {
  const MapPoint* point = map.FindPoint(recent.id);
  if (point == nullptr) return Verdict::kKeep;
  if (statistics_->FoundRatio(recent.id) < kMinFoundRatio) return Verdict::kRemove;
  // Keyframes are inserted while an older one is mapped: their points are not old yet.
  const uint32_t age = newest > recent.made_at ? newest - recent.made_at : 0;
  if (age >= kAgeToBeSeen && CountObservations(map, *point) <= TooFewObservations(map, *point)) {
    return Verdict::kRemove;
  }
  return age >= kAgeToBeKept ? Verdict::kKeep : Verdict::kWait;
}

void RecentPoints::Cull(KeyframeId newest, GuardedMap& guarded) {
  std::vector<Recent> waiting;
  std::vector<MapPointId> removed;
  guarded.Read([&](const Map& map) {
    for (const Recent& recent : recent_) {
      const Verdict verdict = Judge(map, recent, newest.index);
      if (verdict == Verdict::kWait) {
        waiting.push_back(recent);
        continue;
      }
      statistics_->Forget(recent.id);
      if (verdict == Verdict::kRemove) removed.push_back(recent.id);
    }
  });
  recent_ = std::move(waiting);
  guarded.Write([&](Map& map) {
    for (const MapPointId id : removed) map.RemovePoint(id);
  });
}

bool MayGo(const Keyframe& keyframe) {
  return keyframe.parent.IsValid() && keyframe.loop_edges.empty();
}

double ShareSeenBy(Viewers viewers, int enough, const Map& map, const Keyframe& keyframe) {
  int points = 0;
  int seen = 0;
  for (size_t i = 0; i < keyframe.points.size(); ++i) {
    const MapPoint* point = map.FindPoint(keyframe.points[i]);
    if (point == nullptr) continue;
    const Keypoint& keypoint = keyframe.keypoints()[i];
    if (!IsClose(keyframe, keypoint)) continue;
    ++points;
    int others = 0;
    for (const auto& [other_id, other_keypoint] : point->observations) {
      if (!AreOf(viewers, other_id, keyframe.id())) continue;
      const int octave = map.FindKeyframe(other_id)->keypoints()[other_keypoint].octave;
      if (octave <= keypoint.octave + 1 && ++others >= enough) break;
    }
    seen += others >= enough;
  }
  return points > 0 ? static_cast<double>(seen) / points : 0;
}

bool IsRedundant(const Map& map, const Keyframe& keyframe, double share) {
  return ShareSeenBy(Viewers::kOwn, kEnoughOthers, map, keyframe) > share;
}

std::vector<KeyframeId> FindRedundantKeyframes(const Map& map, KeyframeId centre, LocalMapId own) {
  std::vector<KeyframeId> redundant;
  for (const CovisibleKeyframe& relative : map.Covisible(centre)) {
    const Keyframe& keyframe = *map.FindKeyframe(relative.id);
    if (relative.id.local_map != own || !MayGo(keyframe)) continue;
    if (IsRedundant(map, keyframe)) redundant.push_back(relative.id);
  }
  return redundant;
}

void RemoveKeyframeAndItsPoints(KeyframeId id, Map& map) {
  const Keyframe* keyframe = map.FindKeyframe(id);
  if (keyframe == nullptr) return;
  std::vector<MapPointId> seen;
  for (const MapPointId point : keyframe->points) {
    if (point.IsValid()) seen.push_back(point);
  }
  map.RemoveKeyframe(id);
  RemoveWeakPoints(seen, id.local_map, map);
  for (const MapPointId point : seen) {
    if (point.local_map == id.local_map) map.UpdatePointGeometry(point);
  }
}

void RemoveWeakPoints(const std::vector<MapPointId>& points, LocalMapId own, Map& map) {
  for (const MapPointId id : points) {
    const MapPoint* point = map.FindPoint(id);
    if (point == nullptr || id.local_map != own) continue;
    if (CountObservations(map, *point) <= kWeakObservations) map.RemovePoint(id);
  }
}

}  // namespace corbslam::client_agent
