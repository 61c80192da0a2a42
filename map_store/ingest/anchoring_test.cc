// Tests that fusion's points keep their places when keyframes move or go.
#include "map_store/ingest/anchoring.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <variant>

#include "map_store/fusion/revision.h"
#include "map_store/testing/small_mission_state.h"
#include "map_store/view/placement.h"

namespace corbslam::map_store {
namespace {

const Eigen::Vector3d kPlace = {4, -1, 7};

Similarity3d Somewhere(double turn) {
  return {
      1.25, Eigen::Quaterniond(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY())), {1, 0.2, -2}};
}

class AnchoringTest : public corbslam::testing::SmallMissionState {
 protected:
  AnchoringTest() {
    Fuse({{kReference, {Somewhere(0.3), {}, 1}}, {kWitness, {Somewhere(-0.5), {}, 1}}},
         {{kPoint, {kPlace, 1}}});
  }

  void Fuse(std::map<KeyframeId, PlacedKeyframe> keyframes, PlannedPoints points) {
    FuseRecord record;
    record.plan.revision = state_.global.revision + 1;
    record.plan.target = state_.global.island_of.at(kMap);
    record.plan.keyframes = std::move(keyframes);
    record.plan.points = std::move(points);
    RevisionLayers layers = PrepareLayers(record.plan, {}, state_);
    Apply(record, layers, state_);
  }
  void RemoveKeyframe(KeyframeId id, KeyframeId parent) {
    MapUpdateBatch batch;
    batch.removed_keyframes = {{id, parent, {}}};
    ApplyNext(batch);
  }
  Eigen::Vector3d PlaceOf(MapPointId id) const {
    const auto placed = FindPlaced(id, state_.global);
    return placed.has_value() ? placed->PositionInIsland() : Eigen::Vector3d::Zero();
  }
};

TEST_F(AnchoringTest, APointLiesWhereItWasPut) {
  EXPECT_LT((PlaceOf(kPoint) - kPlace).norm(), 1e-12);
  EXPECT_EQ(state_.global.points.at(kPoint).anchor, kReference);
  EXPECT_FALSE(FindPlaced(kOther, state_.global).has_value());
}

TEST_F(AnchoringTest, ItMovesWithItsAnchorThoughNoPlanNamesIt) {
  Fuse({{kReference, {Somewhere(1.1), {}, 2}}}, {});
  EXPECT_LT((PlaceOf(kPoint) - Somewhere(1.1).Inverse() * (Somewhere(0.3) * kPlace)).norm(), 1e-12);
  EXPECT_EQ(state_.global.points.at(kPoint).revision, 1u);
  EXPECT_EQ(FindPlaced(kPoint, state_.global)->revision(), 2u);
}

TEST_F(AnchoringTest, WhenItsAnchorGoesItStaysWithAnotherThatSeesIt) {
  RemoveKeyframe(kReference, kWitness);
  EXPECT_EQ(state_.global.points.at(kPoint).anchor, kWitness);
  EXPECT_LT((PlaceOf(kPoint) - kPlace).norm(), 1e-12);
  Fuse({{kWitness, {Somewhere(0.1), {}, 2}}}, {});
  EXPECT_LT((PlaceOf(kPoint) - Somewhere(0.1).Inverse() * (Somewhere(-0.5) * kPlace)).norm(),
            1e-12);
}

TEST_F(AnchoringTest, ItIsNotPlacedWhenNoPlacedKeyframeSeesIt) {
  RemoveKeyframe(kWitness, kReference);
  RemoveKeyframe(kReference, {kMap, 2});
  EXPECT_FALSE(state_.global.points.contains(kPoint));
}

TEST_F(AnchoringTest, APointThatStandsForItTakesItsPlace) {
  HandOverPlace(kPoint, kOther, state_);
  EXPECT_LT((PlaceOf(kOther) - kPlace).norm(), 1e-12);
  EXPECT_FALSE(state_.global.points.contains(kPoint));
  HandOverPlace(kOther, MapPointId(), state_);
  EXPECT_TRUE(state_.global.points.empty());
}

}  // namespace
}  // namespace corbslam::map_store
