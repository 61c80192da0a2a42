// Tests that layers of an adjustment that were prepared while owners went on are what they would be
// if they had been prepared in the writers' turn.
#include "map_store/fusion/revision_layers.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "map_store/fusion/revision.h"
#include "map_store/records/record_application.h"
#include "map_store/testing/small_mission.h"
#include "map_store/view/placement.h"

namespace corbslam::map_store {
namespace {

constexpr LocalMapId kMapA = {0xa};
constexpr LocalMapId kMapB = {0xb};
constexpr uint32_t kKeyframes = 30;
constexpr uint32_t kKeypoints = 8;

// Two local maps in one island, whose owners and fusion do what they like.
class Owners {
 public:
  // `points` of each local map.
  Owners(uint64_t seed, uint32_t points) : random_(seed), points_(points) {
    for (const LocalMapId& id : {kMapA, kMapB}) Apply(FirstBatch(id), state_);
    state_.FindLocalMap(kMapA)->closed = true;
    Fuse();
  }

  const MissionState& state() const { return state_; }

  // A batch of anything that changes a graph.
  void GoOn() {
    const LocalMapId id = Chance(0.5) ? kMapA : kMapB;
    MapUpdateBatch batch;
    batch.local_map = id;
    batch.number = state_.FindLocalMap(id)->last_batch + 1;
    for (uint32_t i = Below(3); i > 0; --i) {
      batch.light_keyframes.push_back({{id, Below(kKeyframes)}, Motion(), {id, Below(kKeyframes)}});
    }
    for (uint32_t i = Below(5); i > 0; --i) batch.removed_points.push_back({id, Below(points_)});
    for (uint32_t i = Below(5); i > 0; --i) {
      const LocalMapId of = Chance(0.5) ? kMapA : kMapB;
      batch.replacements.push_back({{id, Below(points_)}, {of, Below(points_)}});
    }
    for (uint32_t i = Below(5); i > 0; --i) {
      const auto kind =
          Chance(0.5) ? ObservationChange::Kind::kAdded : ObservationChange::Kind::kRemoved;
      batch.observations.push_back(
          {kind, {id, Below(points_)}, {id, Below(kKeyframes)}, Below(kKeypoints)});
    }
    if (Chance(0.3)) {
      const uint32_t gone = 1 + Below(kKeyframes - 1);
      batch.removed_keyframes = {{{id, gone}, {id, gone - 1}, {}}};
    }
    Apply(std::move(batch), state_);
  }

  // Plans of half the keyframes and points what an adjustment might.
  RevisionPlan PlanSomething() {
    RevisionPlan plan;
    plan.revision = state_.global.revision + 1;
    plan.target = state_.global.islands.begin()->first;
    for (const auto& [id, local_map] : state_.local_maps) {
      for (const auto& [keyframe, item] : local_map.map.keyframes()) {
        if (Chance(0.7)) Plan(item, plan);
      }
      for (const auto& [point, item] : local_map.map.points()) {
        if (Chance(0.8)) Plan(item, plan);
      }
    }
    return plan;
  }

 private:
  uint32_t Below(uint32_t end) { return static_cast<uint32_t>(random_() % end); }
  bool Chance(double share) { return static_cast<double>(random_() % 1000) < 1000 * share; }
  Rigid3d Motion() {
    return {Eigen::Quaterniond::Identity(), {0.1 * Below(50), 0, 0.1 * Below(50)}};
  }

  static void Apply(MapUpdateBatch batch, MissionState& state) {
    const BatchRecord record{"a", std::make_shared<const MapUpdateBatch>(std::move(batch)), {}};
    map_store::Apply(record, {}, {}, state);
  }

  MapUpdateBatch FirstBatch(LocalMapId id) {
    MapUpdateBatch batch;
    batch.local_map = id;
    batch.number = 1;
    batch.cameras = {std::make_shared<const Camera>(Camera{500, 500, 320, 240, 640, 480, 0.1, 4})};
    for (uint32_t k = 0; k < kKeyframes; ++k) {
      auto payload = std::make_shared<KeyframePayload>();
      payload->id = {id, k};
      payload->features = testing::MakeSmallFeatures();
      const KeyframeId parent = k == 0 ? KeyframeId() : KeyframeId{id, Below(k)};
      batch.full_keyframes.push_back({payload, Motion(), parent});
    }
    for (uint32_t p = 0; p < points_; ++p) {
      FullMapPoint point;
      point.id = {id, p};
      point.position_in_local = {0.1 * p, 0, 5};
      point.reference = {id, Below(kKeyframes)};
      batch.full_points.push_back(point);
      // Most keypoints are taken already, so that most points are seen by none or one.
      for (int i = 0; i < 3; ++i) {
        batch.observations.push_back({ObservationChange::Kind::kAdded,
                                      point.id,
                                      {id, Below(kKeyframes)},
                                      Below(kKeypoints)});
      }
    }
    batch.closes_local_map = true;
    return batch;
  }

  void Fuse() {
    FuseRecord record;
    record.plan = PlanSomething();
    record.plan.decided_anew.clear();
    record.plan.source = state_.global.islands.rbegin()->first;
    for (uint32_t i = 0; i < 20; ++i) {
      record.plan.merges.push_back({{kMapA, Below(points_)}, {kMapB, Below(points_)}});
    }
    RevisionLayers layers = PrepareLayers(record.plan, {}, state_);
    map_store::Apply(record, layers, state_);
  }

  void Plan(const Keyframe& keyframe, RevisionPlan& plan) {
    const KeyframeId id = keyframe.id();
    plan.keyframes[id] = {Similarity3d::FromRigid(Motion()), keyframe.camera_from_map,
                          plan.revision};
    plan.decided_anew.insert(id);
    if (Chance(0.1)) plan.culled.push_back(id);
    const uint32_t keypoint = Below(kKeypoints);
    if (Chance(0.3) && keyframe.points[keypoint].IsValid()) {
      plan.rejected_raw[{id, keypoint}] = keyframe.points[keypoint];
    }
  }
  void Plan(const MapPoint& point, RevisionPlan& plan) {
    const bool anchored = plan.keyframes.contains(point.reference) && Chance(0.9);
    plan.points[point.id] = {Eigen::Vector3d(1, Below(9), 2), plan.revision,
                             anchored ? point.reference : KeyframeId()};
  }

  std::mt19937_64 random_;
  const uint32_t points_;
  MissionState state_;
};

// Lets the owners go on in each pause.
class BusyRead : public LongRead {
 public:
  explicit BusyRead(Owners& owners) : owners_(owners) {}
  absl::Status Pause() override {
    ++pauses_;
    owners_.GoOn();
    return absl::OkStatus();
  }
  int pauses() const { return pauses_; }

 private:
  Owners& owners_;
  int pauses_ = 0;
};

void ExpectSamePoints(const PlacedPoints& a, const PlacedPoints& b) {
  ASSERT_EQ(a.size(), b.size());
  for (auto x = a.begin(), y = b.begin(); x != a.end(); ++x, ++y) {
    ASSERT_EQ(x->first, y->first);
    EXPECT_EQ(x->second.anchor, y->second.anchor) << ToString(x->first);
    EXPECT_EQ(x->second.position_in_anchor, y->second.position_in_anchor) << ToString(x->first);
    EXPECT_EQ(x->second.revision, y->second.revision);
  }
}

// Compares what the state is once the layers are committed.
void ExpectSame(const RevisionPlan& plan, RevisionLayers a, RevisionLayers b,
                const MissionState& state) {
  ASSERT_EQ(a.points.has_value(), b.points.has_value());
  EXPECT_EQ(a.displaced, b.displaced);
  EXPECT_EQ(a.adjusted, b.adjusted);
  EXPECT_EQ(*a.rejected, *b.rejected);
  MissionState with_a = state;
  MissionState with_b = state;
  CommitRevision(plan, a, with_a);
  CommitRevision(plan, b, with_b);
  ASSERT_EQ(with_a.global.keyframes.size(), with_b.global.keyframes.size());
  for (const auto& [id, placed] : with_a.global.keyframes) {
    const PlacedKeyframe& other = with_b.global.keyframes.at(id);
    EXPECT_EQ(placed.camera_from_island.translation, other.camera_from_island.translation);
    EXPECT_EQ(placed.revision, other.revision);
  }
  ExpectSamePoints(with_a.global.points, with_b.global.points);
  ASSERT_EQ(with_a.global.island_from_local.size(), with_b.global.island_from_local.size());
  for (const auto& [id, frame] : with_a.global.island_from_local) {
    EXPECT_EQ(frame.translation, with_b.global.island_from_local.at(id).translation);
  }
}

// The seed, and how many points a local map has: with many, all are prepared as a new table.
class RefreshedLayersTest : public ::testing::TestWithParam<std::pair<uint64_t, uint32_t>> {};

TEST_P(RefreshedLayersTest, AreAsIfTheyWerePreparedNow) {
  const auto [seed, points] = GetParam();
  Owners owners(seed, points);
  const RevisionPlan plan = owners.PlanSomething();
  BusyRead read(owners);
  auto layers = PrepareLayers(plan, {}, owners.state(), read);
  ASSERT_TRUE(layers.ok()) << layers.status();
  EXPECT_EQ(read.pauses() > 0, points > 2000);
  for (uint64_t i = 0; i < seed % 4; ++i) owners.GoOn();
  ASSERT_TRUE(RefreshLayers(plan, {}, owners.state(), *layers));
  ExpectSame(plan, *layers, PrepareLayers(plan, {}, owners.state()), owners.state());
}

TEST_P(RefreshedLayersTest, AreAsAReplayMakesThem) {
  const auto [seed, points] = GetParam();
  Owners owners(seed, points);
  const RevisionPlan plan = owners.PlanSomething();
  RevisionLayers layers = PrepareLayers(plan, {}, owners.state());
  owners.GoOn();
  ASSERT_TRUE(RefreshLayers(plan, {}, owners.state(), layers));
  MissionState live = owners.state();
  MissionState replayed = owners.state();
  RevisionLayers taken = TakeLayers(plan, {}, replayed);
  CommitRevision(plan, layers, live);
  CommitRevision(plan, taken, replayed);
  ExpectSamePoints(live.global.points, replayed.global.points);
  EXPECT_EQ(live.global.rejected, replayed.global.rejected);
  EXPECT_EQ(live.global.islands.begin()->second.displaced,
            replayed.global.islands.begin()->second.displaced);
}

std::vector<std::pair<uint64_t, uint32_t>> Cases() {
  std::vector<std::pair<uint64_t, uint32_t>> cases;
  for (uint64_t seed = 0; seed < 40; ++seed) cases.emplace_back(seed, 300);
  for (uint64_t seed = 40; seed < 48; ++seed) cases.emplace_back(seed, 6000);
  return cases;
}
INSTANTIATE_TEST_SUITE_P(Seeds, RefreshedLayersTest, ::testing::ValuesIn(Cases()),
                         [](const auto& info) { return std::to_string(info.param.first); });

// Returns how many points fusion is said to have moved after `revision`.
size_t CountMoved(const MissionState& state, uint64_t revision) {
  size_t moved = 0;
  for (const auto& [id, point] : state.global.points) {
    const std::optional<PlacedAnchor> placed = FindPlaced(id, state.global);
    moved += placed.has_value() && placed->revision() > revision;
  }
  return moved;
}

// The same plan again and again, with what the test changes of it.
class PlannedAgainTest : public ::testing::Test {
 protected:
  PlannedAgainTest() { plan_.culled.clear(); }

  // Returns how many points are said to have moved.
  size_t Commit() {
    RevisionLayers layers = PrepareLayers(plan_, {}, state_);
    CommitRevision(plan_, layers, state_);
    const size_t moved = CountMoved(state_, plan_.revision - 1);
    ++plan_.revision;
    for (auto& [id, keyframe] : plan_.keyframes) keyframe.revision = plan_.revision;
    for (auto& [id, point] : plan_.points) point.revision = plan_.revision;
    return moved;
  }

  Owners owners_{3, 300};
  MissionState state_ = owners_.state();
  RevisionPlan plan_ = owners_.PlanSomething();
};

TEST_F(PlannedAgainTest, WhatStaysWhereItWasHasNotMoved) {
  const size_t moved = Commit();
  ASSERT_GT(moved, 100u);
  EXPECT_EQ(Commit(), 0u);
  PlacedKeyframe& turned = plan_.keyframes.begin()->second;
  turned.camera_from_island.translation.x() += 0.1;
  const size_t of_one = Commit();
  EXPECT_GT(of_one, 0u);
  EXPECT_LT(of_one, moved / 4);
  // That it was looked at again is known all the same.
  EXPECT_EQ(state_.global.keyframes.at(plan_.keyframes.rbegin()->first).revision,
            plan_.revision - 1);
}

// At the depth of 4 m that the camera knows well, eight millimetres are a pixel.
TEST_F(PlannedAgainTest, WhatNobodyCouldSeeIsToldOnceItHasAddedUp) {
  Commit();
  const auto move_all = [this] {
    for (auto& [id, planned] : plan_.keyframes) {
      planned.camera_from_island.translation.x() += 1.5e-3;
    }
    for (auto& [id, point] : plan_.points) point.position_in_island.x() -= 1.5e-3;
    return Commit();
  };
  size_t told = 0;
  for (int i = 0; i < 4; ++i) told += move_all();
  EXPECT_EQ(told, 0u);
  for (int i = 0; i < 3; ++i) told += move_all();
  EXPECT_GT(told, 100u);
}

// Points that move in the cameras that see them, which stay.
TEST_F(PlannedAgainTest, SoItIsOfPointsAlone) {
  Commit();
  size_t told = 0;
  for (int i = 0; i < 5; ++i) {
    for (auto& [id, point] : plan_.points) point.position_in_island.y() += 1e-4;
    told += Commit();
  }
  EXPECT_EQ(told, 0u);
  for (int i = 0; i < 100; ++i) {
    for (auto& [id, point] : plan_.points) point.position_in_island.y() += 1e-3;
    told += Commit();
  }
  EXPECT_GT(told, 100u);
  EXPECT_LT(told, 100u * 300u) << "of some hundred points, seldom";
}

TEST(RefreshedLayersTest, AreUselessWhereTheStateHasForgottenWhatChanged) {
  Owners owners(1, 300);
  const RevisionPlan plan = owners.PlanSomething();
  RevisionLayers layers = PrepareLayers(plan, {}, owners.state());
  owners.GoOn();
  MissionState state = owners.state();
  ForgetChanges(state, *state.FindLocalMap(kMapA));
  EXPECT_FALSE(RefreshLayers(plan, {}, state, layers));
}

}  // namespace
}  // namespace corbslam::map_store
