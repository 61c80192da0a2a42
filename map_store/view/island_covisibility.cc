#include "map_store/view/island_covisibility.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// The pieces of a long read.
constexpr size_t kKeyframesInAPiece = 64;
constexpr size_t kLandmarksInAPiece = 1000;

// Counts for pairs of numbered things. Only pairs that were counted take room.
class PairCounts {
 public:
  // `a` must be greater than `b`.
  uint32_t& At(uint32_t a, uint32_t b) { return counts_[uint64_t{a} << 32 | b]; }

  struct Count {
    uint32_t a = 0;
    uint32_t b = 0;
    uint32_t count = 0;
  };
  // Returns the counts by a, then by b.
  std::vector<Count> Sorted() const {
    std::vector<std::pair<uint64_t, uint32_t>> sorted(counts_.begin(), counts_.end());
    std::ranges::sort(sorted);
    std::vector<Count> counts;
    counts.reserve(sorted.size());
    for (const auto& [pair, count] : sorted) {
      counts.push_back({static_cast<uint32_t>(pair >> 32), static_cast<uint32_t>(pair), count});
    }
    return counts;
  }

 private:
  absl::flat_hash_map<uint64_t, uint32_t> counts_;
};

// A keyframe that sees a landmark, and by which of its names. Owners have counted the pairs of
// sightings by one name.
struct Sighting {
  uint32_t keyframe = 0;
  MapPointId name;
  bool is_foreign = false;
};

class Counter {
 public:
  Counter(const MissionState& state, const Island& island, LongRead& read)
      : state_(state), island_(island), read_(read), keyframes_(KeyframesOf(state, island)) {
    index_.reserve(keyframes_.size());
    for (uint32_t i = 0; i < keyframes_.size(); ++i) index_[keyframes_[i]] = i;
  }

  absl::Status AddOwnersCounts() {
    for (uint32_t i = 0; i < keyframes_.size(); ++i) {
      RETURN_IF_ERROR(PauseAfter(kKeyframesInAPiece, i));
      const Keyframe* keyframe = state_.FindKeyframe(keyframes_[i]);
      if (keyframe == nullptr) continue;
      for (const auto& [other, weight] : keyframe->covisible) {
        const auto j = index_.find(other);
        if (j != index_.end() && j->second < i) {
          counts_.At(i, j->second) += static_cast<uint32_t>(weight);
        }
      }
    }
    return absl::OkStatus();
  }

  absl::Status CollectLandmarks() {
    std::vector<MapPointId> survivors;
    for (const auto& [survivor, members] : state_.global.landmarks.sets()) {
      if (IsHere(survivor.local_map)) survivors.push_back(survivor);
    }
    for (size_t i = 0; i < survivors.size(); ++i) {
      RETURN_IF_ERROR(PauseAfter(kLandmarksInAPiece, i));
      const auto set = state_.global.landmarks.sets().find(survivors[i]);
      if (set == state_.global.landmarks.sets().end()) continue;
      std::vector<Sighting>& sightings = landmarks_[set->first];
      AddOwnSightings(set->first, sightings);
      for (const MapPointId& member : set->second) AddOwnSightings(member, sightings);
    }
    return absl::OkStatus();
  }

  absl::Status CollectForeignObservations() {
    for (uint32_t i = 0; i < keyframes_.size(); ++i) {
      RETURN_IF_ERROR(PauseAfter(kKeyframesInAPiece, i));
      const KeyframeId keyframe = keyframes_[i];
      const auto& foreign = state_.FindLocalMap(keyframe.local_map)->foreign_observations;
      const auto seen = foreign.find(keyframe);
      if (seen == foreign.end()) continue;
      for (const auto& [keypoint, raw] : seen->second) AddForeignSighting(i, raw);
    }
    return absl::OkStatus();
  }

  absl::Status CountLandmarks() {
    size_t done = 0;
    for (const auto& [survivor, sightings] : landmarks_) {
      RETURN_IF_ERROR(PauseAfter(kLandmarksInAPiece, done++));
      for (size_t i = 0; i < sightings.size(); ++i) {
        for (size_t j = 0; j < i; ++j) CountPair(sightings[i], sightings[j]);
      }
    }
    return absl::OkStatus();
  }

  std::vector<CovisiblePair> Take() {
    std::vector<CovisiblePair> pairs;
    for (const PairCounts::Count& pair : counts_.Sorted()) {
      const auto weight = static_cast<int>(pair.count);
      if (weight > 0) pairs.push_back({keyframes_[pair.b], keyframes_[pair.a], weight});
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

  absl::Status PauseAfter(size_t piece, size_t done) {
    return done > 0 && done % piece == 0 ? read_.Pause() : absl::OkStatus();
  }

  bool IsHere(LocalMapId id) const {
    const auto it = state_.global.island_of.find(id);
    return it != state_.global.island_of.end() && it->second == island_.id;
  }

  void AddOwnSightings(MapPointId id, std::vector<Sighting>& sightings) const {
    const MapPoint* point = IsHere(id.local_map) ? state_.FindPoint(id) : nullptr;
    if (point == nullptr) return;
    for (const auto& [keyframe, keypoint] : point->observations) {
      // A keyframe that came during a pause doesn't count.
      const auto it = index_.find(keyframe);
      if (it != index_.end()) sightings.push_back({it->second, id});
    }
  }

  void AddForeignSighting(uint32_t keyframe, MapPointId raw) {
    const MapPointId survivor = ResolvePoint(state_, raw);
    if (!survivor.IsValid() || !IsHere(survivor.local_map)) return;
    const auto [it, added] = landmarks_.try_emplace(survivor);
    if (added) AddOwnSightings(survivor, it->second);
    it->second.push_back({keyframe, raw, true});
  }

  void CountPair(const Sighting& a, const Sighting& b) {
    const bool counted_by_owner = a.name == b.name && !a.is_foreign && !b.is_foreign;
    if (counted_by_owner || a.keyframe == b.keyframe) return;
    ++counts_.At(std::max(a.keyframe, b.keyframe), std::min(a.keyframe, b.keyframe));
  }

  const MissionState& state_;
  const Island& island_;
  LongRead& read_;
  const std::vector<KeyframeId> keyframes_;  // Ascending.
  absl::flat_hash_map<KeyframeId, uint32_t> index_;
  PairCounts counts_;
  absl::flat_hash_map<MapPointId, std::vector<Sighting>> landmarks_;
};

}  // namespace

absl::StatusOr<std::vector<CovisiblePair>> CountCovisibility(const MissionState& state,
                                                             const Island& island, LongRead& read) {
  Counter counter(state, island, read);
  RETURN_IF_ERROR(counter.AddOwnersCounts());
  RETURN_IF_ERROR(counter.CollectLandmarks());
  RETURN_IF_ERROR(counter.CollectForeignObservations());
  RETURN_IF_ERROR(read.Pause());
  RETURN_IF_ERROR(counter.CountLandmarks());
  RETURN_IF_ERROR(read.Pause());
  return counter.Take();
}

}  // namespace corbslam::map_store
