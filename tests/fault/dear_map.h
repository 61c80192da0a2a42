// A local map whose batches are valid, and as dear to a map store as its limits allow: what a robot
// with a good token may send to the mission of others.
#ifndef CORBSLAM_TESTS_FAULT_DEAR_MAP_H_
#define CORBSLAM_TESTS_FAULT_DEAR_MAP_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "slam/exchange/map_update.h"

namespace corbslam::tests {

struct DearSizes {
  // Keyframes of the chain, in which each hangs on the one before.
  size_t keyframes = 1500;
  // Features of each of them; every one sees a point of its own.
  size_t features = 20;
  // So many keyframes are made to see the same points.
  size_t crowd = 127;
  // Keyframes of a second local map, in which each hangs on the one after: none of those before a
  // keyframe can be its parent.
  size_t reversed = 1400;
  // Features of one keyframe that sees nothing but points of robots that are not there.
  size_t wide_features = 20000;
  // Items of a batch of observations or replacements at most.
  size_t items = 64'000;
  // Keyframes of as many features in one batch: 18 of 20,000 are just below 16 MiB.
  size_t full_keyframes = 18;
  // References to what never arrives; the store's limit is 65,000.
  size_t parked = 65'000;
};

// What is sent, without its number: whoever sends it counts.
struct DearBatch {
  std::string kind;
  MapUpdateBatch batch;
};

// Returns how many entries all lists of the batch have together.
size_t CountItems(const MapUpdateBatch& batch);

// Not thread-safe. Two local maps, `first` and the id after it.
class DearMap {
 public:
  DearMap(LocalMapId first, const DearSizes& sizes);

  // Returns what all the others build on, which is to be acknowledged first.
  std::vector<DearBatch> Foundation() const;
  // Returns each kind once, with other values in each round; what is parked stays so.
  std::vector<DearBatch> Round(uint32_t round);
  // What goes beyond a limit, or against a rule that keeps prices down, and what the store is to
  // say of it. To be sent only after a round: then as much is parked as may be.
  struct Refused {
    std::string kind;
    MapUpdateBatch batch;
    std::string says;  // A part of the message.
  };
  std::vector<Refused> BeyondLimits() const;

 private:
  KeyframeId Chain(size_t i) const { return {first_, static_cast<uint32_t>(i)}; }
  KeyframeId Reversed(size_t i) const { return {second_, static_cast<uint32_t>(i)}; }
  // The keyframe behind the chain that has `wide_features`.
  KeyframeId Wide() const { return Chain(sizes_.keyframes); }
  MapPointId PointOf(size_t keyframe, size_t feature) const {
    return {first_, static_cast<uint32_t>(keyframe * sizes_.features + feature)};
  }
  MapUpdateBatch Empty(LocalMapId local_map) const;
  FullKeyframe MakeKeyframe(KeyframeId id, KeyframeId parent, size_t features) const;
  FullMapPoint MakePoint(MapPointId id, KeyframeId reference) const;
  MapUpdateBatch MakeChain() const;
  MapUpdateBatch MakeReversed() const;
  MapUpdateBatch MoveChain(uint32_t round) const;
  MapUpdateBatch ChangeParents(uint32_t round) const;
  MapUpdateBatch NameForeignParents() const;
  MapUpdateBatch MovePoints(uint32_t round) const;
  MapUpdateBatch SeeAndUnsee() const;
  MapUpdateBatch CrowdAndPart() const;
  MapUpdateBatch TooManySteps() const;
  MapUpdateBatch SeeForeign(uint32_t round) const;
  MapUpdateBatch ParkAll() const;
  MapUpdateBatch RetryParked();
  MapUpdateBatch ReplaceInAChain();
  MapUpdateBatch FillWithFeatures(size_t keyframes, size_t features) const;

  const LocalMapId first_;
  const LocalMapId second_;
  const DearSizes sizes_;
  const std::shared_ptr<const Camera> camera_;
  // The index of the next point that nothing stands for yet.
  uint32_t next_point_;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_FAULT_DEAR_MAP_H_
