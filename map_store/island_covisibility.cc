#include "map_store/island_covisibility.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "absl/container/flat_hash_map.h"

namespace corbslam::map_store {
namespace {

// Counts for all pairs of so many things; half a square of them.
class PairCounts {
 public:
  explicit PairCounts(size_t size) : counts_(size * (size + 1) / 2, 0) {}

  // a > b.
  uint32_t& At(size_t a, size_t b) { return counts_[a * (a - 1) / 2 + b]; }

 private:
  std::vector<uint32_t> counts_;
};

// A keyframe that sees a landmark, and by which of its names. Owners have counted those of one
// name.
struct Sighting {
  uint32_t keyframe = 0;
  MapPointId name;
  bool is_foreign = false;
};

class Counter {
 public:
  Counter(const MissionState& state, const Island& island)
      : state_(state),
        island_(island),
        keyframes_(KeyframesOf(state, island)),
        counts_(keyframes_.size()) {
    index_.reserve(keyframes_.size());
    for (uint32_t i = 0; i < keyframes_.size(); ++i) index_[keyframes_[i]] = i;
  }

  void AddOwnersCounts() {
    for (uint32_t i = 0; i < keyframes_.size(); ++i) {
      for (const auto& [other, weight] : state_.FindKeyframe(keyframes_[i])->covisible) {
        const uint32_t j = index_.at(other);
        if (j < i) counts_.At(i, j) += static_cast<uint32_t>(weight);
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

  std::vector<CovisiblePair> Take() {
    std::vector<CovisiblePair> pairs;
    for (uint32_t i = 0; i < keyframes_.size(); ++i) {
      for (uint32_t j = 0; j < i; ++j) {
        const auto weight = static_cast<int>(counts_.At(i, j));
        if (weight > 0) pairs.push_back({keyframes_[j], keyframes_[i], weight});
      }
    }
    return pairs;
  }

 private:
  static std::vector<KeyframeId> KeyframesOf(const MissionState& state, const Island& island) {
    std::vector<KeyframeId> keyframes;
    for (const LocalMapId& id : island.local_maps) {
      for (const auto& [keyframe, item] : state.FindLocalMap(id)->map.keyframes()) {
        keyframes.push_back(keyframe);
      }
    }
    std::sort(keyframes.begin(), keyframes.end());
    return keyframes;
  }

  bool IsHere(LocalMapId id) const {
    const auto it = state_.global.island_of.find(id);
    return it != state_.global.island_of.end() && it->second == island_.id;
  }

  void AddOwnSightings(MapPointId id, std::vector<Sighting>& sightings) const {
    const MapPoint* point = IsHere(id.local_map) ? state_.FindPoint(id) : nullptr;
    if (point == nullptr) return;
    for (const auto& [keyframe, keypoint] : point->observations) {
      sightings.push_back({index_.at(keyframe), id});
    }
  }

  void AddForeignSighting(KeyframeId keyframe, MapPointId raw) {
    const MapPointId survivor = ResolvePoint(state_, raw);
    if (!survivor.IsValid() || !IsHere(survivor.local_map)) return;
    const auto [it, added] = landmarks_.try_emplace(survivor);
    if (added) AddOwnSightings(survivor, it->second);
    it->second.push_back({index_.at(keyframe), raw, true});
  }

  void CountPair(const Sighting& a, const Sighting& b) {
    const bool counted_by_owner = a.name == b.name && !a.is_foreign && !b.is_foreign;
    if (counted_by_owner || a.keyframe == b.keyframe) return;
    ++counts_.At(std::max(a.keyframe, b.keyframe), std::min(a.keyframe, b.keyframe));
  }

  const MissionState& state_;
  const Island& island_;
  const std::vector<KeyframeId> keyframes_;  // Ascending.
  absl::flat_hash_map<KeyframeId, uint32_t> index_;
  PairCounts counts_;
  absl::flat_hash_map<MapPointId, std::vector<Sighting>> landmarks_;
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
