// Three robots' maps around a ring and the store of their mission, for tests of what robots are
// told.
#ifndef CORBSLAM_MAP_STORE_TESTING_SHARING_MISSION_H_
#define CORBSLAM_MAP_STORE_TESTING_SHARING_MISSION_H_

#include <gtest/gtest.h>

#include <memory>

#include "map_store/store/map_store.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"

namespace corbslam::testing {

inline constexpr char kMission[] = "m";

class SharingMission : public ::testing::Test {
 protected:
  void Fuse() { ASSERT_TRUE(store_.RunFusionUntilIdle(kMission).ok()); }

  SyntheticMap map_a_ = MakeRingMap(0xa, 0, 14);
  SyntheticMap map_b_ = MakeRingMap(0xb, 32, 14);
  SyntheticMap map_c_ = MakeRingMap(0xc, 64, 14);
  TruthfulWorker worker_{{&map_a_, &map_b_, &map_c_}};
  map_store::MapStore store_{DeterministicOptions(), TheWorld().vocabulary,
                             std::make_unique<map_store::InMemoryJournal>(), &worker_};
};

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_SHARING_MISSION_H_
