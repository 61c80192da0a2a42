#include "client_agent/map/near_map.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

namespace corbslam::client_agent {
namespace {

// Points or keyframes that are looked at while writers wait: some 0.2 ms.
constexpr size_t kStepsInAPiece = 2000;
// After so many corrections meanwhile the map is read in one piece.
constexpr int kMaxTries = 3;

template <typename Item>
struct Found {
  double distance = 0;
  Item item;
};
struct FoundPoint {
  Eigen::Vector3f position;
  bool shared = false;
};

template <typename Item>
using AllFound = std::vector<Found<Item>>;

// Goes through `items(map)`, an ordered container of the map, `piece` at a time; `visit` adds what
// is near.
template <typename Id, typename Items, typename Visit>
void ReadInPieces(const GuardedMap& map, size_t piece, const Items& items, const Visit& visit) {
  std::optional<Id> last;
  bool goes_on = true;
  while (goes_on) {
    goes_on = map.Read([&](const Map& now) {
      const auto& all = items(now);
      auto it = last.has_value() ? all.upper_bound(*last) : all.begin();
      for (size_t steps = 0; it != all.end() && steps < piece; ++it, ++steps) {
        visit(it->second);
        last = it->first;
      }
      return it != all.end();
    });
  }
}

struct Near {
  AllFound<FoundPoint> points;
  AllFound<NearMap::NearKeyframe> keyframes;
};

Near ReadNear(const GuardedMap& map, const Eigen::Vector3d& centre, double radius_m, size_t piece) {
  Near near;
  ReadInPieces<MapPointId>(
      map, piece, [](const Map& now) -> const auto& { return now.points(); },
      [&](const MapPoint& point) {
        const double distance = (point.position_in_map - centre).norm();
        if (!(distance <= radius_m)) return;
        near.points.push_back(
            {distance, {point.position_in_map.cast<float>(), !map.IsOwn(point.id)}});
      });
  ReadInPieces<KeyframeId>(
      map, piece, [](const Map& now) -> const auto& { return now.keyframes(); },
      [&](const Keyframe& keyframe) {
        const double distance = (CameraCentre(keyframe.camera_from_map) - centre).norm();
        if (!(distance <= radius_m)) return;
        near.keyframes.push_back(
            {distance,
             {keyframe.id(), keyframe.camera_from_map.Inverse(), !map.IsOwn(keyframe.id())}});
      });
  return near;
}

Near ReadConsistently(const GuardedMap& map, const Eigen::Vector3d& centre, double radius_m) {
  for (int tries = 0; tries < kMaxTries; ++tries) {
    const uint64_t corrections = map.corrections();
    Near near = ReadNear(map, centre, radius_m, kStepsInAPiece);
    if (map.corrections() == corrections) return near;
  }
  return ReadNear(map, centre, radius_m, std::numeric_limits<size_t>::max());
}

// Keeps the nearest, in their order. Returns whether there were more.
template <typename Item>
bool KeepNearest(size_t most, AllFound<Item>& found) {
  const auto is_nearer = [](const Found<Item>& a, const Found<Item>& b) {
    return a.distance < b.distance;
  };
  const bool is_more = found.size() > most;
  if (is_more) {
    std::nth_element(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(most), found.end(),
                     is_nearer);
    found.resize(most);
  }
  std::sort(found.begin(), found.end(), is_nearer);
  return is_more;
}

}  // namespace

NearMap FindNearMap(const GuardedMap& map, const Eigen::Vector3d& centre,
                    const NearMapLimits& limits) {
  Near near = ReadConsistently(map, centre, limits.radius_m);
  NearMap found;
  found.local_map = map.local_map();
  found.centre = centre;
  const bool more_points = KeepNearest(limits.max_points, near.points);
  const bool more_keyframes = KeepNearest(limits.max_keyframes, near.keyframes);
  found.truncated = more_points || more_keyframes;
  for (const auto& [distance, point] : near.points) {
    (point.shared ? found.shared_points : found.own_points).push_back(point.position);
  }
  for (const auto& [distance, keyframe] : near.keyframes) found.keyframes.push_back(keyframe);
  return found;
}

}  // namespace corbslam::client_agent
