// Tests the store with maps of one camera alone: they come to one unit, and to metres where a map
// has them.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "map_store/store/map_store.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "slam/fusing/map_fusing.h"
#include "slam/verification/place_verification.h"

namespace corbslam::map_store {
namespace {

using testing::DeterministicOptions;
using testing::MakeSyntheticMap;
using testing::PosesOnRing;
using testing::SyntheticMap;
using testing::SyntheticMapOptions;
using testing::TestAgent;
using testing::TheWorld;

constexpr char kMixedMission[] = "m";

// Verifies and fuses as workers do, and leaves a map that is to be adjusted as it is.
class EstimatingWorker : public FusionWorker {
 public:
  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest& request,
                                                    const ProgressCallback&) override {
    VerifyOverlapResult result;
    result.base_revision = request.base_revision;
    PlaceVerificationOptions options;
    options.fix_scale = request.fix_scale;
    for (const VerifyOverlapRequest::Candidate& candidate : request.candidates) {
      result.overlaps.push_back(VerifyPlace(*request.query_view, request.query,
                                            request.candidate_view, candidate.id, options));
      if (result.overlaps.back().IsAccepted()) break;
    }
    return result;
  }
  absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest& request,
                                          const ProgressCallback& progress) override {
    return corbslam::FuseMaps(request, {}, progress);
  }
  absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest& request,
                                                  const ProgressCallback&) override {
    AdjustBundleResult result;
    result.base_revision = request.base_revision;
    for (const auto& [id, keyframe] : request.view.keyframes()) {
      result.poses.push_back({id, Similarity3d::FromRigid(keyframe.camera_from_map)});
    }
    return result;
  }
};

SyntheticMap MakeMap(uint64_t local_map, double begin_degrees, double scale) {
  SyntheticMapOptions options;
  options.local_map = {local_map};
  options.seed = local_map;
  options.scale = scale;
  return MakeSyntheticMap(TheWorld().world, PosesOnRing(begin_degrees, 4, 14), options);
}

class WithoutMetresTest : public ::testing::Test {
 protected:
  void Start(std::vector<SyntheticMap> maps) {
    maps_ = std::move(maps);
    store_ = std::make_unique<MapStore>(DeterministicOptions(), TheWorld().vocabulary,
                                        std::make_unique<InMemoryJournal>(), &worker_);
    for (size_t i = 0; i < maps_.size(); ++i) {
      agents_.push_back(std::make_unique<TestAgent>(
          *store_, kMixedMission, std::string(1, static_cast<char>('a' + i)), maps_[i]));
      ASSERT_TRUE(agents_.back()->Stream().ok());
      ASSERT_TRUE(store_->RunFusionUntilIdle(kMixedMission).ok());
    }
  }
  LocalMapInfo InfoOf(size_t agent) const {
    return store_->GetLocalMap(kMixedMission, agents_[agent]->local_map()).value();
  }
  Similarity3d CameraFromIsland(size_t agent, uint32_t index) const {
    return store_->GetKeyframe(kMixedMission, agents_[agent]->Id(index))->camera_from_island;
  }
  Eigen::Vector3d TrueCentre(size_t agent, uint32_t index) const {
    return CameraCentre(maps_[agent].true_camera_from_world.at(agents_[agent]->Id(index)));
  }
  // How many of the island's units are between two cameras for each metre that is there in truth.
  double UnitsPerMetre(size_t agent_a, uint32_t a, size_t agent_b, uint32_t b) const {
    const double units = (CameraCentre(CameraFromIsland(agent_a, a).ToRigid()) -
                          CameraCentre(CameraFromIsland(agent_b, b).ToRigid()))
                             .norm();
    return units / (TrueCentre(agent_a, a) - TrueCentre(agent_b, b)).norm();
  }

  EstimatingWorker worker_;
  std::vector<SyntheticMap> maps_;
  std::unique_ptr<MapStore> store_;
  std::vector<std::unique_ptr<TestAgent>> agents_;
};

TEST_F(WithoutMetresTest, ALoneMapIsSaidToHaveNone) {
  Start({MakeMap(0xb, 0, 0.4)});
  EXPECT_FALSE(InfoOf(0).in_metres);
  EXPECT_FALSE(InfoOf(0).island_in_metres);
  ASSERT_TRUE(agents_[0]->TakeShared().ok());
}

TEST_F(WithoutMetresTest, TwoComeToOneUnit) {
  Start({MakeMap(0xb, 0, 0.4), MakeMap(0xc, 24, 2.5)});
  ASSERT_EQ(InfoOf(0).island, InfoOf(1).island);
  EXPECT_FALSE(InfoOf(1).island_in_metres);
  const double unit = UnitsPerMetre(0, 0, 0, 10);
  EXPECT_NEAR(UnitsPerMetre(1, 3, 1, 12) / unit, 1, 0.02);
  EXPECT_NEAR(UnitsPerMetre(0, 1, 1, 12) / unit, 1, 0.02);
}

// Whichever came first: the frame of the mission's first map, too, gets metres.
TEST_F(WithoutMetresTest, AMapWithMetresGivesThem) {
  for (const bool metric_first : {true, false}) {
    agents_.clear();
    Start(metric_first ? std::vector{MakeMap(0xb, 0, 1), MakeMap(0xc, 24, 0.4)}
                       : std::vector{MakeMap(0xb, 0, 0.4), MakeMap(0xc, 24, 1)});
    const size_t metric = metric_first ? 0 : 1;
    ASSERT_EQ(InfoOf(0).island, InfoOf(1).island);
    EXPECT_TRUE(InfoOf(metric).in_metres);
    EXPECT_FALSE(InfoOf(1 - metric).in_metres);
    EXPECT_TRUE(InfoOf(1 - metric).island_in_metres);
    EXPECT_NEAR(UnitsPerMetre(1 - metric, 2, 1 - metric, 12), 1, 0.02);
    EXPECT_NEAR(UnitsPerMetre(0, 1, 1, 12), 1, 0.02);
    EXPECT_EQ(CameraFromIsland(metric, 5).scale, 1) << "metres are not measured anew";
    ASSERT_TRUE(agents_[1 - metric]->TakeShared().ok());
  }
}

// A merge of two maps without metres says how they stand to each other in their own units: that it
// holds when a third one gives metres to both.
TEST_F(WithoutMetresTest, EarlierMergesHoldWhenMetresCome) {
  Start({MakeMap(0xb, 0, 0.4), MakeMap(0xc, 24, 2.5), MakeMap(0xd, 48, 1)});
  ASSERT_EQ(InfoOf(0).island, InfoOf(2).island);
  ASSERT_EQ(InfoOf(1).island, InfoOf(2).island);
  for (size_t agent = 0; agent < 3; ++agent) {
    EXPECT_NEAR(UnitsPerMetre(agent, 1, agent, 12), 1, 0.02) << agent;
  }
  EXPECT_NEAR(UnitsPerMetre(0, 1, 2, 12), 1, 0.02);
  EXPECT_TRUE(InfoOf(0).island_in_metres);
}

}  // namespace
}  // namespace corbslam::map_store
