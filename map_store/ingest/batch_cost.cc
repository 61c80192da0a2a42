#include "map_store/ingest/batch_cost.h"

#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/strings/str_cat.h"

namespace corbslam::map_store {
namespace {

// So many steps up the tree cost as much as counting a pair.
constexpr uint64_t kParentsOfAPair = 4;

uint64_t PairsOf(uint64_t viewers) { return viewers * viewers / 2; }

class StepCounter {
 public:
  explicit StepCounter(const LocalMapState* local_map) : local_map_(local_map) {}

  void Add(const ObservationChange& change) {
    uint64_t& viewers = ViewersOf(change.point);
    steps_ += viewers;
    if (change.kind != ObservationChange::Kind::kAdded) return;
    if (added_.insert({change.point, change.keyframe}).second) ++viewers;
  }
  void Add(const PointReplacement& replacement) {
    // The replaced point is taken from all its pairs, and counted again with the survivor's
    // viewers.
    const uint64_t replaced = ViewersOf(replacement.replaced);
    uint64_t& survivors = ViewersOf(replacement.survivor);
    steps_ += 2 * PairsOf(replaced) + replaced * survivors;
    survivors += replaced;
  }
  void Add(const MapPointId& removed) { steps_ += PairsOf(ViewersOf(removed)); }
  void Add(const KeyframeRemoval& removal) {
    const Keyframe* keyframe = Find(removal.id);
    if (keyframe == nullptr) return;
    for (const MapPointId& point : keyframe->points) {
      if (point.IsValid()) steps_ += ViewersOf(point);
    }
    // Each keyframe below the removed one is looked at once.
    AddWayUp();
  }
  void Add(const LightKeyframe& light) {
    const Keyframe* keyframe = Find(light.id);
    if (keyframe == nullptr || keyframe->parent == light.parent || !light.parent.IsValid()) return;
    // A keyframe without children makes no cycle.
    if (!keyframe->children.empty()) AddWayUp();
  }

  uint64_t steps() const { return steps_ + parents_ / kParentsOfAPair; }

 private:
  const Keyframe* Find(KeyframeId id) const {
    return local_map_ == nullptr ? nullptr : local_map_->map.FindKeyframe(id);
  }
  void AddWayUp() { parents_ += local_map_->arrived.size(); }
  // Returns how many keyframes of the point's own local map see it, those included that this batch
  // added so far.
  uint64_t& ViewersOf(MapPointId id) {
    const auto [it, is_new] = viewers_.try_emplace(id, 0);
    if (is_new && local_map_ != nullptr) {
      const MapPoint* point = local_map_->map.FindPoint(id);
      if (point != nullptr) it->second = point->observations.size();
    }
    return it->second;
  }

  const LocalMapState* const local_map_;
  absl::flat_hash_map<MapPointId, uint64_t> viewers_;
  absl::flat_hash_set<std::pair<MapPointId, KeyframeId>> added_;
  uint64_t steps_ = 0;
  uint64_t parents_ = 0;
};

}  // namespace

uint64_t CountPairSteps(const LocalMapState* local_map, const MapUpdateBatch& batch) {
  StepCounter counter(local_map);
  const auto add = [&counter](const auto& list) {
    for (const auto& item : list) counter.Add(item);
  };
  add(batch.light_keyframes);
  add(batch.replacements);
  add(batch.observations);
  add(batch.removed_points);
  add(batch.removed_keyframes);
  return counter.steps();
}

absl::Status ValidateCost(const LocalMapState* local_map, const MapUpdateBatch& batch,
                          const MapStoreOptions& options) {
  const uint64_t steps = CountPairSteps(local_map, batch);
  if (steps <= options.max_pair_steps_per_batch) return absl::OkStatus();
  return absl::ResourceExhaustedError(absl::StrCat(
      "batch ", batch.number, " takes ", steps,
      " steps, for pairs of keyframes that see a point together and for parents; the limit is ",
      options.max_pair_steps_per_batch));
}

}  // namespace corbslam::map_store
