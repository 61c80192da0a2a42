#include "client_agent/mapping/culling.h"

#include <optional>
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
// Of others, in one drive.
constexpr int kLooksOfKnown = 4;

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

// True if the keyframe saw what is at its keypoint at the same or a finer scale; one level of
// slack.
bool IsAsFine(const Map& map, KeyframeId id, size_t keypoint, int octave) {
  return map.FindKeyframe(id)->keypoints()[keypoint].octave <= octave + 1;
}

// Returns the share of the keyframe's close points, each given with its octave there, of which
// `is_enough` is true; 0 if it has none.
template <typename IsEnough>
double ShareOfClosePoints(const Map& map, const Keyframe& keyframe, const IsEnough& is_enough) {
  int points = 0;
  int enough = 0;
  for (size_t i = 0; i < keyframe.points.size(); ++i) {
    const MapPoint* point = map.FindPoint(keyframe.points[i]);
    const Keypoint& keypoint = keyframe.keypoints()[i];
    if (point == nullptr || !IsClose(keyframe, keypoint)) continue;
    ++points;
    enough += is_enough(*point, keypoint.octave);
  }
  return points > 0 ? static_cast<double>(enough) / points : 0;
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

double ShareKnownToOthers(const Map& map, const Keyframe& keyframe) {
  return ShareOfClosePoints(map, keyframe, [&](const MapPoint& point, int octave) {
    int looks = 0;
    std::optional<LocalMapId> first;
    for (const auto& [id, keypoint] : point.observations) {
      const bool is_others = id.local_map != keyframe.id().local_map;
      if (!is_others || !IsAsFine(map, id, keypoint, octave)) continue;
      if (++looks >= kLooksOfKnown || id.local_map != first.value_or(id.local_map)) return true;
      first = id.local_map;
    }
    return false;
  });
}

bool IsRedundant(const Map& map, const Keyframe& keyframe, double share) {
  const double seen = ShareOfClosePoints(map, keyframe, [&](const MapPoint& point, int octave) {
    int others = 0;
    for (const auto& [id, keypoint] : point.observations) {
      const bool is_own = id.local_map == keyframe.id().local_map && id != keyframe.id();
      if (is_own && IsAsFine(map, id, keypoint, octave) && ++others >= kEnoughOthers) return true;
    }
    return false;
  });
  return seen > share;
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
