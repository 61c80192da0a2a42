// A mission's state after the first batch of a small mission, for tests of what batches and plans
// make of it.
#ifndef CORBSLAM_MAP_STORE_TESTING_SMALL_MISSION_STATE_H_
#define CORBSLAM_MAP_STORE_TESTING_SMALL_MISSION_STATE_H_

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <variant>

#include "map_store/records/record_application.h"
#include "map_store/state/mission_state.h"
#include "map_store/testing/small_mission.h"

namespace corbslam::testing {

class SmallMissionState : public ::testing::Test {
 protected:
  static constexpr LocalMapId kMap = kSmallMapA;
  static constexpr MapPointId kPoint = {kMap, 1};
  static constexpr MapPointId kOther = {kMap, 2};
  // The keyframe that all points follow, and another one that sees them.
  static constexpr KeyframeId kReference = {kMap, 0};
  static constexpr KeyframeId kWitness = {kMap, 1};

  SmallMissionState() { ApplyRecord(std::get<map_store::BatchRecord>(MakeSmallMission()[0])); }

  void ApplyRecord(const map_store::BatchRecord& record) {
    map_store::Apply(record, {}, {}, state_);
  }
  // Applies it as the next batch of the local map.
  void ApplyNext(MapUpdateBatch batch) {
    batch.local_map = kMap;
    batch.number = state_.FindLocalMap(kMap)->last_batch + 1;
    ApplyRecord({"a", std::make_shared<const MapUpdateBatch>(std::move(batch)), {}});
  }

  map_store::MissionState state_;
};

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_SMALL_MISSION_STATE_H_
