#include "map_store/ingest/batch_cost.h"

#include <gtest/gtest.h>

#include <memory>

#include "map_store/ingest/batch_application.h"

namespace corbslam::map_store {
namespace {

using Kind = ObservationChange::Kind;

constexpr LocalMapId kMap{0xa};
constexpr uint32_t kKeyframes = 64;
constexpr KeyframeId Kf(uint32_t index) { return {kMap, index}; }
constexpr MapPointId Pt(uint32_t index) { return {kMap, index}; }

MapUpdateBatch Empty(uint64_t number) {
  MapUpdateBatch batch;
  batch.local_map = kMap;
  batch.number = number;
  return batch;
}

// Returns a chain of keyframes, all of which see point 0; point 1 is seen by the first of them.
MapUpdateBatch MakeChain() {
  MapUpdateBatch batch = Empty(1);
  batch.cameras = {std::make_shared<const Camera>(Camera{500, 500, 320, 240, 640, 480, 0.1, 4})};
  for (uint32_t i = 0; i < kKeyframes; ++i) {
    Features features;
    features.keypoints.resize(3);
    features.descriptors.resize(3);
    batch.full_keyframes.push_back(
        {MakeKeyframePayload(Kf(i), 100 * i, 0, batch.cameras[0], features), Rigid3d::Identity(),
         i == 0 ? KeyframeId() : Kf(i - 1)});
    batch.observations.push_back({Kind::kAdded, Pt(0), Kf(i), 0});
  }
  for (uint32_t i = 0; i < 2; ++i) {
    batch.full_points.push_back(
        {Pt(i), Eigen::Vector3d::UnitZ(), Kf(0), Descriptor(), Eigen::Vector3d::UnitZ(), 1, 2});
  }
  batch.observations.push_back({Kind::kAdded, Pt(1), Kf(0), 1});
  return batch;
}

class BatchCostTest : public ::testing::Test {
 protected:
  BatchCostTest() {
    LocalMapState& local_map = AddLocalMap(state_, kMap, "agent");
    ApplyBatch(MakeChain(), {}, options_, state_, local_map);
  }
  uint64_t Count(const MapUpdateBatch& batch) const {
    return CountPairSteps(state_.FindLocalMap(kMap), batch);
  }

  MapStoreOptions options_;
  MissionState state_;
};

TEST_F(BatchCostTest, ACrowdComingCostsItsPairs) {
  EXPECT_EQ(CountPairSteps(nullptr, MakeChain()), kKeyframes * (kKeyframes - 1) / 2);
}

TEST_F(BatchCostTest, EachSightCostsAsManyAsSeeThePoint) {
  MapUpdateBatch batch = Empty(2);
  batch.observations = {{Kind::kRemoved, Pt(0), Kf(3), 0}, {Kind::kAdded, Pt(1), Kf(3), 0}};
  EXPECT_EQ(Count(batch), kKeyframes + 1);
  batch.observations.assign(10, {Kind::kAdded, Pt(1), Kf(3), 0});
  EXPECT_EQ(Count(batch), 1 + 9 * 2) << "it sees it once, however often that is said";
}

TEST_F(BatchCostTest, RemovalsAndReplacementsCostPairs) {
  MapUpdateBatch batch = Empty(2);
  batch.removed_points = {Pt(0)};
  EXPECT_EQ(Count(batch), kKeyframes * kKeyframes / 2);
  batch = Empty(2);
  batch.replacements = {{Pt(0), Pt(1)}};
  EXPECT_EQ(Count(batch), kKeyframes * kKeyframes + kKeyframes);
  batch = Empty(2);
  batch.removed_keyframes = {{Kf(0), KeyframeId(), Rigid3d::Identity()}};
  EXPECT_EQ(Count(batch), kKeyframes + 1 + kKeyframes / 4);
}

TEST_F(BatchCostTest, OnlyANewParentIsLookedFor) {
  MapUpdateBatch batch = Empty(2);
  batch.light_keyframes = {{Kf(9), Rigid3d::Identity(), Kf(8)}};
  EXPECT_EQ(Count(batch), 0);
  batch.light_keyframes = {{Kf(9), Rigid3d::Identity(), Kf(7)}};
  EXPECT_EQ(Count(batch), kKeyframes / 4);
  batch.light_keyframes = {{Kf(kKeyframes - 1), Rigid3d::Identity(), Kf(7)}};
  EXPECT_EQ(Count(batch), 0) << "nothing hangs on it";
}

TEST_F(BatchCostTest, IsRefusedBeyondItsLimitByNumbers) {
  const MapUpdateBatch batch = MakeChain();
  options_.max_pair_steps_per_batch = kKeyframes * (kKeyframes - 1) / 2;
  EXPECT_TRUE(ValidateCost(nullptr, batch, options_).ok());
  --options_.max_pair_steps_per_batch;
  const absl::Status refused = ValidateCost(nullptr, batch, options_);
  EXPECT_TRUE(absl::IsResourceExhausted(refused));
  EXPECT_EQ(refused.message(),
            "batch 1 takes 2016 steps, for pairs of keyframes that see a point together and for "
            "parents; the limit is 2015");
}

}  // namespace
}  // namespace corbslam::map_store
