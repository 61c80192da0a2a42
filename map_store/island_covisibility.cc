#include "map_store/island_covisibility.h"

#include <algorithm>
#include <utility>

#include "absl/container/flat_hash_map.h"

namespace corbslam::map_store {
namespace {

using Pair = std::pair<KeyframeId, KeyframeId>;

// A keyframe that sees a landmark, and by which name of it. Owners have counted those of one name.
struct Sighting {
  KeyframeId keyframe;
  MapPointId name;
  bool is_foreign = false;
};

class Counter {
 public:
  Counter(const MissionState& state, const Island& island) : state_(state), island_(island) {}

  void AddOwnersCounts() {
    for (const LocalMapId& id : island_.local_maps) {
      for (const auto& [a, keyframe] : state_.FindLocalMap(id)->map.keyframes()) {
        for (const auto& [b, weight] : keyframe.covisible) {
          if (a < b) counts_[{a, b}] += weight;
        }
      }
    }
  }

  void CollectLandmarks() {
    for (const auto& [survivor, members] : state_.global.landmarks.sets()) {
      if (!IsHere(survivor.local_map)) continue;
      std::vector<Sighting>& sightings = landmarks_[survivor];
      AddOwnSightings(survivor, sightings);
      for (const MapPointId& member : members) AddOwnSightings(member, sightings);
    }
  }

  void CollectForeignObservations() {
    for (const LocalMapId& id : island_.local_maps) {
      for (const auto& [keyframe, seen] : state_.FindLocalMap(id)->foreign_observations) {
        for (const auto& [keypoint, raw] : seen) AddForeignSighting(keyframe, raw);
      }
    }
  }

  void CountLandmarks() {
    for (const auto& [survivor, sightings] : landmarks_) {
      for (size_t i = 0; i < sightings.size(); ++i) {
        for (size_t j = 0; j < i; ++j) CountPair(sightings[i], sightings[j]);
      }
    }
  }

  std::vector<CovisiblePair> Take() const {
    std::vector<CovisiblePair> pairs;
    pairs.reserve(counts_.size());
    for (const auto& [pair, weight] : counts_) pairs.push_back({pair.first, pair.second, weight});
    return pairs;
  }

 private:
  bool IsHere(LocalMapId id) const {
    const auto it = state_.global.island_of.find(id);
    return it != state_.global.island_of.end() && it->second == island_.id;
  }

  void AddOwnSightings(MapPointId id, std::vector<Sighting>& sightings) const {
    const MapPoint* point = IsHere(id.local_map) ? state_.FindPoint(id) : nullptr;
    if (point == nullptr) return;
    for (const auto& [keyframe, keypoint] : point->observations) {
      sightings.push_back({keyframe, id});
    }
  }

  void AddForeignSighting(KeyframeId keyframe, MapPointId raw) {
    const MapPointId survivor = ResolvePoint(state_, raw);
    if (!survivor.IsValid() || !IsHere(survivor.local_map)) return;
    const auto [it, added] = landmarks_.try_emplace(survivor);
    if (added) AddOwnSightings(survivor, it->second);
    it->second.push_back({keyframe, raw, true});
  }

  void CountPair(const Sighting& a, const Sighting& b) {
    const bool counted_by_owner = a.name == b.name && !a.is_foreign && !b.is_foreign;
    if (counted_by_owner || a.keyframe == b.keyframe) return;
    ++counts_[{std::min(a.keyframe, b.keyframe), std::max(a.keyframe, b.keyframe)}];
  }

  const MissionState& state_;
  const Island& island_;
  absl::flat_hash_map<MapPointId, std::vector<Sighting>> landmarks_;
  absl::flat_hash_map<Pair, int> counts_;
};

}  // namespace

std::vector<CovisiblePair> CountCovisibility(const MissionState& state, const Island& island) {
  Counter counter(state, island);
  counter.AddOwnersCounts();
  counter.CollectLandmarks();
  counter.CollectForeignObservations();
  counter.CountLandmarks();
  return counter.Take();
}

}  // namespace corbslam::map_store
