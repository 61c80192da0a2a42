// Tests the store with maps of one camera alone: they come to one unit, and to metres where a map
// has them.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "map_store/store/map_store.h"
#include "map_store/testing/byte_journal.h"
#include "map_store/testing/recover_undamaged.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "slam/fusing/map_fusing.h"
#include "slam/verification/place_verification.h"

namespace corbslam::map_store {
namespace {

using testing::ByteJournal;
using testing::DeterministicOptions;
using testing::JournalBytes;
using testing::MakeSyntheticMap;
using testing::PosesOnRing;
using testing::RecoverUndamaged;
using testing::SyntheticMap;
using testing::SyntheticMapOptions;
using testing::TestAgent;
using testing::TheWorld;

constexpr char kMixedMission[] = "m";

// Verifies and fuses as workers do, and gives back a map that is to be adjusted as it is, or
// larger.
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
      Rigid3d pose = keyframe.camera_from_map;
      pose.translation *= stretch;
      result.poses.push_back({id, Similarity3d::FromRigid(pose)});
    }
    for (const auto& [id, point] : request.view.points()) {
      result.positions.push_back({id, stretch * point.position_in_map});
    }
    return result;
  }

  // An adjustment makes the island so many times as large.
  double stretch = 1;
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
  void Open(std::vector<SyntheticMap> maps) {
    agents_.clear();
    maps_ = std::move(maps);
    bytes_ = std::make_shared<JournalBytes>();
    store_ = std::make_unique<MapStore>(DeterministicOptions(), TheWorld().vocabulary,
                                        std::make_unique<ByteJournal>(bytes_), &worker_);
    for (size_t i = 0; i < maps_.size(); ++i) {
      agents_.push_back(std::make_unique<TestAgent>(
          *store_, kMixedMission, std::string(1, static_cast<char>('a' + i)), maps_[i]));
    }
  }
  // Each map comes whole, and is fused before the next one does.
  void Start(std::vector<SyntheticMap> maps) {
    Open(std::move(maps));
    DriveOn(std::vector<size_t>(maps_.size(), 1000));
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

  void ExpectMetres(size_t agent, uint32_t begin, uint32_t end) const {
    for (uint32_t i = begin + 1; i < end; ++i) {
      EXPECT_NEAR(UnitsPerMetre(agent, begin, agent, i), 1, 0.02) << agent << " " << i;
    }
  }
  // Streams the maps' keyframes by turns, the second one's last ones after all was fused.
  void DriveOn(const std::vector<size_t>& keyframes) {
    for (size_t i = 0; i < agents_.size(); ++i) {
      ASSERT_TRUE(agents_[i]->Stream(keyframes[i]).ok());
      ASSERT_TRUE(store_->RunFusionUntilIdle(kMixedMission).ok());
    }
  }

  EstimatingWorker worker_;
  std::vector<SyntheticMap> maps_;
  std::shared_ptr<JournalBytes> bytes_;
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
    const Rigid3d island_from_world =
        CameraFromIsland(metric, 0).ToRigid().Inverse() *
        maps_[metric].true_camera_from_world.at(agents_[metric]->Id(0));
    for (uint32_t i = 0; i < 14; ++i) {
      const Eigen::Vector3d found = CameraCentre(CameraFromIsland(1 - metric, i).ToRigid());
      EXPECT_LT((found - island_from_world * TrueCentre(1 - metric, i)).norm(), 0.05) << i;
    }
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

TEST_F(WithoutMetresTest, AnyOfThreeMayHaveMetres) {
  for (const size_t metric : {0, 1}) {
    std::vector<SyntheticMap> maps;
    for (size_t i = 0; i < 3; ++i) {
      maps.push_back(MakeMap(0xb + i, 24.0 * static_cast<double>(i),
                             i == metric ? 1 : 0.3 + static_cast<double>(i)));
    }
    Start(std::move(maps));
    for (size_t agent = 0; agent < 3; ++agent) {
      EXPECT_TRUE(InfoOf(agent).island_in_metres) << metric << " " << agent;
      ExpectMetres(agent, 1, 13);
    }
  }
}

TEST_F(WithoutMetresTest, AnyUnitWillDo) {
  for (const double scale : {0.01, 100.0}) {
    Start({MakeMap(0xb, 0, 1), MakeMap(0xc, 26, scale)});
    EXPECT_TRUE(InfoOf(1).island_in_metres) << scale;
    ExpectMetres(1, 0, 14);
    ASSERT_TRUE(agents_[1]->TakeShared().ok());
  }
}

// Pictures that all were taken at one place say no scale, whatever depths the maps have for them.
TEST_F(WithoutMetresTest, TurningOnTheSpotGivesNone) {
  std::vector<Rigid3d> poses;
  for (int i = 0; i < 10; ++i) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.03 * i, Eigen::Vector3d::UnitY()));
    poses.push_back(Rigid3d{turn, Eigen::Vector3d::Zero()} * testing::PoseOnRing(30));
  }
  std::vector<SyntheticMap> maps;
  for (const auto& [local_map, scale] : {std::pair(0xb, 1.0), std::pair(0xc, 0.4)}) {
    SyntheticMapOptions options;
    options.local_map = {static_cast<uint64_t>(local_map)};
    options.seed = options.local_map.value;
    options.scale = scale;
    maps.push_back(MakeSyntheticMap(TheWorld().world, poses, options));
  }
  Start(std::move(maps));
  EXPECT_NE(InfoOf(0).island, InfoOf(1).island);
  EXPECT_FALSE(InfoOf(1).island_in_metres);
  EXPECT_FALSE(store_->ListOverlaps(kMixedMission, {}, {})->items.empty()) << "it was looked up";
}

// What comes after the merge, and is not placed yet, follows by its own map's unit.
TEST_F(WithoutMetresTest, ItsRobotDrivesOnInMetres) {
  Open({MakeMap(0xb, 0, 1), MakeMap(0xc, 24, 0.4)});
  DriveOn({14, 8});
  ASSERT_TRUE(InfoOf(1).island_in_metres);
  ASSERT_TRUE(agents_[1]->Stream().ok());
  ExpectMetres(1, 2, 14);
  ASSERT_TRUE(store_->RunFusionUntilIdle(kMixedMission).ok());
  ExpectMetres(1, 2, 14);
}

TEST_F(WithoutMetresTest, ScalesFollowAnAdjustmentThatStretches) {
  worker_.stretch = 1.1;
  Open({MakeMap(0xb, 0, 0.4), MakeMap(0xc, 24, 2.5)});
  DriveOn({14, 8});
  ASSERT_TRUE(agents_[1]->Stream().ok());
  ASSERT_FALSE(store_->GetStatistics(kMixedMission)->global_adjustments.empty());
  // A unit of the first map is 2.5 m.
  for (const uint32_t i : {2u, 9u}) {
    EXPECT_NEAR(CameraFromIsland(0, i).scale * UnitsPerMetre(0, 1, 0, i), 0.4, 0.008) << i;
  }
  EXPECT_NEAR(UnitsPerMetre(1, 1, 1, 13) / UnitsPerMetre(1, 1, 1, 4), 1, 0.02);
}

TEST_F(WithoutMetresTest, ARestartedStoreKnowsTheSame) {
  Start({MakeMap(0xb, 0, 0.4), MakeMap(0xc, 24, 2.5), MakeMap(0xd, 48, 1)});
  std::vector<Similarity3d> before;
  for (uint32_t i = 0; i < 14; ++i) before.push_back(CameraFromIsland(1, i));
  store_ = std::make_unique<MapStore>(DeterministicOptions(), TheWorld().vocabulary,
                                      std::make_unique<ByteJournal>(bytes_), &worker_);
  ASSERT_TRUE(RecoverUndamaged(*store_).ok());
  for (uint32_t i = 0; i < 14; ++i) {
    EXPECT_EQ(CameraFromIsland(1, i).scale, before[i].scale) << i;
    EXPECT_EQ(CameraFromIsland(1, i).translation, before[i].translation) << i;
  }
  EXPECT_TRUE(InfoOf(1).island_in_metres);
}

TEST_F(WithoutMetresTest, AMergeTakenBackTakesMetresWithIt) {
  Start({MakeMap(0xb, 0, 1), MakeMap(0xc, 24, 0.4)});
  const auto accepted = store_->ListOverlaps(kMixedMission, {true, {}}, {});
  ASSERT_FALSE(accepted->items.empty());
  ASSERT_TRUE(store_->RetractOverlap(kMixedMission, accepted->items.front().id, true).ok());
  ASSERT_TRUE(store_->RunFusionUntilIdle(kMixedMission).ok());
  EXPECT_NE(InfoOf(0).island, InfoOf(1).island);
  EXPECT_FALSE(InfoOf(1).island_in_metres);
  EXPECT_TRUE(InfoOf(0).island_in_metres);
  EXPECT_NEAR(UnitsPerMetre(1, 0, 1, 13), 0.4, 0.001) << "its own unit again";
  ASSERT_TRUE(agents_[1]->TakeShared().ok());
}

}  // namespace
}  // namespace corbslam::map_store
