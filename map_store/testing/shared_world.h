// A small world and its vocabulary, made once for all tests of a binary.
#ifndef CORBSLAM_MAP_STORE_TESTING_SHARED_WORLD_H_
#define CORBSLAM_MAP_STORE_TESTING_SHARED_WORLD_H_

#include <cstdint>
#include <memory>

#include "map_store/options/options.h"
#include "map_store/testing/test_agent.h"
#include "slam/verification/testing/synthetic_world.h"

namespace corbslam::testing {

struct SharedWorld {
  SyntheticWorld world = MakeRingWorld(7, 2500);
  std::shared_ptr<const Vocabulary> vocabulary = MakeTestVocabulary(world);
};
inline const SharedWorld& TheWorld() {
  static const SharedWorld* const world = new SharedWorld();
  return *world;
}

// Makes a map with a keyframe every 4 degrees of the ring.
inline SyntheticMap MakeRingMap(uint64_t local_map, double begin_degrees, int keyframes,
                                double drift_yaw_rad = 0.002) {
  SyntheticMapOptions options;
  options.local_map = {local_map};
  options.seed = local_map;
  options.drift_yaw_rad = drift_yaw_rad;
  return MakeSyntheticMap(TheWorld().world, PosesOnRing(begin_degrees, 4, keyframes), options);
}

inline map_store::MapStoreOptions DeterministicOptions() {
  map_store::MapStoreOptions options;
  options.deterministic = true;
  options.settle_after = 3;
  options.share_after = 3;
  return options;
}

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_SHARED_WORLD_H_
