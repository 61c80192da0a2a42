// Two robots' maps that meet, the store of their mission, and a worker that knows the truth.
#ifndef CORBSLAM_MAP_STORE_TESTING_TWO_ROBOTS_H_
#define CORBSLAM_MAP_STORE_TESTING_TWO_ROBOTS_H_

#include <gtest/gtest.h>

#include <memory>

#include "map_store/store/map_store.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"

namespace corbslam::testing {

class TwoRobots : public ::testing::Test {
 protected:
  static constexpr char kMission[] = "m";

  void StreamBoth() {
    ASSERT_TRUE(a_.Stream().ok());
    ASSERT_TRUE(b_.Stream().ok());
  }
  void CloseBoth() {
    ASSERT_TRUE(a_.Close().ok());
    ASSERT_TRUE(b_.Close().ok());
  }
  void Fuse() { ASSERT_TRUE(store_.RunFusionUntilIdle(kMission).ok()); }
  map_store::MissionStatistics Statistics() { return *store_.GetStatistics(kMission); }
  Similarity3d Pose(KeyframeId id) { return store_.GetKeyframe(kMission, id)->camera_from_island; }
  // Returns b_from_a by the global layer.
  Rigid3d Relative(KeyframeId a, KeyframeId b) {
    return Pose(b).ToRigid() * Pose(a).ToRigid().Inverse();
  }
  static Rigid3d TrueRelative(const SyntheticMap& a, KeyframeId from, const SyntheticMap& b,
                              KeyframeId to) {
    return b.true_camera_from_world.at(to) * a.true_camera_from_world.at(from).Inverse();
  }
  // Returns the sum of metres and radians.
  static double Difference(const Rigid3d& a, const Rigid3d& b) {
    const Rigid3d difference = a * b.Inverse();
    return difference.translation.norm() + RotationAngle(difference.rotation);
  }

  SyntheticMap map_a_ = MakeRingMap(0xa, 0, 14);
  SyntheticMap map_b_ = MakeRingMap(0xb, 32, 14);
  TruthfulWorker worker_{{&map_a_, &map_b_}};
  map_store::MapStore store_{DeterministicOptions(), TheWorld().vocabulary,
                             std::make_unique<map_store::InMemoryJournal>(), &worker_};
  TestAgent a_{store_, kMission, "a", map_a_};
  TestAgent b_{store_, kMission, "b", map_b_};
};

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_TWO_ROBOTS_H_
