// A replica fed with batches alone must stay equal to the observed map, whatever happens to it.
#include "client_agent/upload/update_recorder.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "client_agent/upload/outbox.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr LocalMapId kOwn{1};
constexpr LocalMapId kForeign{2};
constexpr uint32_t kKeypoints = 30;

Keyframe MakeKeyframe(KeyframeId id, KeyframeId parent) {
  static const auto camera = std::make_shared<const Camera>(Camera{
      .fx_px = 500, .fy_px = 500, .cx_px = 320, .cy_px = 240, .width_px = 640, .height_px = 480});
  Features features;
  features.keypoints.resize(kKeypoints);
  features.descriptors.resize(kKeypoints);
  // By which they are known where some are left out.
  for (uint32_t i = 0; i < kKeypoints; ++i) features.keypoints[i].x_px = static_cast<float>(i);
  Keyframe keyframe;
  keyframe.payload = MakeKeyframePayload(id, id.index, 0, camera, features);
  keyframe.parent = parent;
  return keyframe;
}

void MoveWithFollowers(KeyframeId id, const Rigid3d& camera_from_map, Map& replica) {
  const Rigid3d now_from_before =
      camera_from_map.Inverse() * replica.FindKeyframe(id)->camera_from_map;
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> moved;
  for (const auto& [point_id, point] : replica.points()) {
    if (point.reference != id) continue;
    moved.emplace_back(point_id, now_from_before * point.position_in_map);
  }
  for (const auto& [point_id, position] : moved) replica.SetPosition(point_id, position);
  replica.SetPose(id, camera_from_map);
}

struct Store {
  // One of an older version moves no points with their keyframes.
  bool is_old = false;
  // The root is never removed: then no parent makes a cycle with what was there before.
  bool root_stays = false;
};

// What a map store does with a batch.
void Apply(const MapUpdateBatch& batch, const Store& store, Map& replica) {
  std::vector<std::pair<KeyframeId, KeyframeId>> parked;
  for (const FullKeyframe& full : batch.full_keyframes) {
    Keyframe keyframe;
    keyframe.payload = full.payload;
    keyframe.camera_from_map = full.camera_from_local;
    keyframe.parent = full.parent;
    EXPECT_TRUE(replica.AddKeyframe(keyframe));
  }
  for (const FullMapPoint& full : batch.full_points) {
    MapPoint point;
    point.id = full.id;
    point.position_in_map = full.position_in_local;
    point.reference = full.reference;
    EXPECT_NE(replica.FindKeyframe(full.reference), nullptr);
    EXPECT_TRUE(replica.AddPoint(point));
  }
  for (const LightKeyframe& light : batch.light_keyframes) {
    if (batch.points_follow && !store.is_old) {
      MoveWithFollowers(light.id, light.camera_from_local, replica);
    } else {
      replica.SetPose(light.id, light.camera_from_local);
    }
    if (light.parent.IsValid() && !replica.SetParent(light.id, light.parent)) {
      EXPECT_FALSE(store.root_stays) << ToString(light.id) << " on " << ToString(light.parent);
      parked.emplace_back(light.id, light.parent);
    }
  }
  for (const LightMapPoint& light : batch.light_points) {
    replica.SetPosition(light.id, light.position_in_local);
  }
  for (const PointReplacement& r : batch.replacements) {
    EXPECT_TRUE(replica.ReplacePoint(r.replaced, r.survivor));
  }
  for (const ObservationChange& change : batch.observations) {
    const bool done = change.kind == ObservationChange::Kind::kAdded
                          ? replica.AddObservation(change.point, change.keyframe, change.keypoint)
                          : replica.RemoveObservation(change.point, change.keyframe);
    EXPECT_TRUE(done) << ToString(change.point) << " in " << ToString(change.keyframe);
  }
  for (const MapPointId& id : batch.removed_points) EXPECT_TRUE(replica.RemovePoint(id));
  for (const KeyframeRemoval& removal : batch.removed_keyframes) replica.RemoveKeyframe(removal.id);
  // Those that would have made a cycle with what was there before.
  for (const auto& [id, parent] : parked) EXPECT_TRUE(replica.SetParent(id, parent));
}

class Scenario {
 public:
  explicit Scenario(uint32_t seed, const RecorderOptions& options = {.hold_newest = 0})
      : random_(seed),
        options_(options),
        recorder_(std::make_unique<UpdateRecorder>(kOwn, options)) {
    // Where trees are the same on both sides whenever a batch has gone up, it may be removed.
    store_.root_stays =
        options.hold_newest > 0 || options.limits.light_keyframes < BatchLimits().light_keyframes;
    map_.SetObserver(recorder_.get());
    // A few foreign points that both sides hold, as after sharing.
    AddForeignPoints(map_);
    AddForeignPoints(replica_);
  }

  void Step() {
    switch (random_() % 10) {
      case 0:
      case 1:
        return AddKeyframe();
      case 2:
      case 3:
        return AddPoint();
      case 4:
      case 5:
      case 6:
        map_.AddObservation(AnyPoint(), AnyKeyframe(),
                            static_cast<uint32_t>(random_()) % kKeypoints);
        return;
      case 7:
        return Move();
      case 8:
        return Remove();
      case 9:
        if (const MapPointId replaced = AnyPoint(); replaced.local_map == kOwn) {
          map_.ReplacePoint(replaced, AnyPoint());
        }
        return;
    }
  }

  MapUpdateBatch Flush(size_t max_keyframes) {
    const MapUpdateBatch batch = recorder_->TakeBatch(map_, max_keyframes);
    Apply(batch, store_, replica_);
    ApplyToKept(batch);
    return batch;
  }
  // The robot hears of it only when a session opens.
  void ReplaceStore(bool is_old) {
    store_.is_old = is_old;
    keeps_ = keeps_ && !is_old;
  }
  void OpenSession() { recorder_->SetPointsFollow(!store_.is_old); }
  // With so many bytes; returns what was told.
  MapUpdateBatch FlushBytes(double bytes) {
    const MapUpdateBatch batch = recorder_->TakeBatch(map_, BatchAllowance(1000, bytes, 1));
    Apply(batch, store_, replica_);
    ApplyToKept(batch);
    return batch;
  }
  UpdateCounts CountUntold() const { return recorder_->CountUntold(); }
  bool HasChanges() const { return recorder_->HasChanges(); }

  // The robot's process ends after the last batch, and the next one goes on with what was kept.
  void Restart() {
    map_ = Map();
    kept_.Fill([](const auto&) { return nullptr; }, map_);
    AddForeignPoints(map_);
    recorder_ = std::make_unique<UpdateRecorder>(kOwn, options_);
    recorder_->GoOnFrom(kept_);
    map_.SetObserver(recorder_.get());
    next_keyframe_ = std::max(next_keyframe_, kept_.next_keyframe());
    restarted_ = true;
  }

  // What is kept is what the store has.
  void ExpectKeptIsReplica() const {
    ASSERT_EQ(kept_.keyframes().size(), replica_.keyframes().size());
    for (const auto& [id, keyframe] : replica_.keyframes()) {
      EXPECT_EQ(kept_.observations().keyframes().at(id), keyframe.points) << ToString(id);
      const FullKeyframe& kept = kept_.keyframes().at(id);
      EXPECT_EQ(kept.camera_from_local.translation, keyframe.camera_from_map.translation);
      EXPECT_LT(id.index, kept_.next_keyframe());
    }
    for (const auto& [id, point] : replica_.points()) {
      if (id.local_map != kOwn) continue;
      ASSERT_TRUE(kept_.points().contains(id)) << ToString(id);
      const Eigen::Vector3d& position = kept_.points().at(id).position_in_local;
      EXPECT_LT((position - point.position_in_map).norm(), 1e-6 * (1 + position.norm()));
    }
  }

  // Telling it as a whole tells the same.
  void ExpectWholeIsTheSame() const {
    KeptMap again(kOwn);
    for (const MapUpdateBatch& batch : kept_.ToBatches(3, 5)) {
      const absl::Status applied = again.Apply(batch);
      ASSERT_TRUE(applied.ok()) << applied;
    }
    EXPECT_EQ(again.observations().keyframes(), kept_.observations().keyframes());
    EXPECT_EQ(again.next_keyframe(), kept_.next_keyframe());
    EXPECT_EQ(again.next_point(), kept_.next_point());
    EXPECT_EQ(again.newest_ns(), kept_.newest_ns());
    EXPECT_EQ(again.points().size(), kept_.points().size());
    for (const auto& [id, keyframe] : kept_.keyframes()) {
      EXPECT_EQ(again.keyframes().at(id).parent, keyframe.parent);
    }
  }

  // Where nobody can tell the difference from the pictures.
  void ExpectPlacesThatLookTheSame() const {
    for (const auto& [id, point] : map_.points()) {
      const MapPoint* told = replica_.FindPoint(id);
      if (told == nullptr) continue;
      for (const auto& [keyframe_id, keypoint] : point.observations) {
        const Keyframe& keyframe = *map_.FindKeyframe(keyframe_id);
        const Eigen::Vector3d is = keyframe.camera_from_map * point.position_in_map;
        const Eigen::Vector3d believed = keyframe.camera_from_map * told->position_in_map;
        if (is == believed) continue;
        ASSERT_GT(is.z(), 0) << ToString(id);
        ASSERT_GT(believed.z(), 0) << ToString(id);
        const Eigen::Vector3d apart_px =
            500 * (is / is.z() - believed / believed.z());  // Of the focal length above.
        EXPECT_LE(apart_px.norm(), 0.5 + 1e-6) << ToString(id) << " in " << ToString(keyframe_id);
      }
    }
  }
  // Tells exactly; there is nothing left afterwards.
  void ExpectExactPlaces() {
    recorder_->AskForExactPlaces();
    for (int i = 0; i < 20 && HasChanges(); ++i) Flush(1000);
    EXPECT_FALSE(HasChanges());
    for (const auto& [id, point] : replica_.points()) {
      const Eigen::Vector3d& is = map_.FindPoint(id)->position_in_map;
      EXPECT_LT((point.position_in_map - is).norm(), 2e-6 * (1 + is.norm())) << ToString(id);
    }
  }

  void ExpectEqual() const {
    ASSERT_EQ(map_.keyframes().size(), replica_.keyframes().size());
    for (const auto& [id, keyframe] : map_.keyframes()) {
      const Keyframe& other = *replica_.FindKeyframe(id);
      for (size_t k = 0; k < other.points.size(); ++k) {
        const MapPointId seen = keyframe.points[NumberOf(other, k)];
        // Others' points come back when the store shares them again.
        if (restarted_ && !seen.IsValid() && other.points[k].local_map == kForeign) continue;
        EXPECT_EQ(seen, other.points[k]) << ToString(id);
      }
      EXPECT_EQ(keyframe.camera_from_map.translation, other.camera_from_map.translation);
      if (keyframe.parent.IsValid()) {
        EXPECT_EQ(keyframe.parent, other.parent);
      }
    }
    for (const auto& [id, point] : replica_.points()) {
      EXPECT_NE(map_.FindPoint(id), nullptr) << ToString(id);
    }
    for (const auto& [id, point] : map_.points()) {
      // What nobody sees need not be told.
      if (!IsSeenInReplica(point)) continue;
      EXPECT_NE(replica_.FindPoint(id), nullptr) << ToString(id);
    }
    ExpectPlacesThatLookTheSame();
  }

 private:
  static void AddForeignPoints(Map& map) {
    for (uint32_t i = 0; i < 10; ++i) {
      MapPoint point;
      point.id = {kForeign, i};
      map.AddPoint(point);
    }
  }
  void ApplyToKept(const MapUpdateBatch& batch) {
    if (!keeps_) return;
    const absl::Status applied = kept_.Apply(batch);
    EXPECT_TRUE(applied.ok()) << applied;
  }
  // On the robot, of a keypoint at the store.
  static size_t NumberOf(const Keyframe& told, size_t keypoint) {
    return static_cast<size_t>(told.keypoints()[keypoint].x_px);
  }
  bool IsSeenInReplica(const MapPoint& point) const {
    for (const auto& [id, keypoint] : point.observations) {
      const Keyframe* told = replica_.FindKeyframe(id);
      for (size_t k = 0; told != nullptr && k < told->points.size(); ++k) {
        if (NumberOf(*told, k) == keypoint) return true;
      }
    }
    return false;
  }
  void AddKeyframe() {
    const KeyframeId parent = AnyKeyframe();
    map_.AddKeyframe(MakeKeyframe({kOwn, next_keyframe_++}, parent));
  }
  void AddPoint() {
    MapPoint point;
    point.id = {kOwn, next_point_++};
    point.reference = AnyKeyframe();
    point.position_in_map = {static_cast<double>(random_() % 100), 0, 500};
    map_.AddPoint(point);
    map_.AddObservation(point.id, point.reference, static_cast<uint32_t>(random_()) % kKeypoints);
  }
  void Move() {
    if (const MapPointId id = AnyPoint(); id.local_map == kOwn) {
      map_.SetPosition(id, map_.FindPoint(id)->position_in_map + AnyStep());
    }
    const KeyframeId id = AnyKeyframe();
    if (!id.IsValid()) return;
    Rigid3d pose = map_.FindKeyframe(id)->camera_from_map;
    pose.rotation =
        (Eigen::AngleAxisd(1e-3 * AnyStep().x(), Eigen::Vector3d::UnitY()) * pose.rotation)
            .normalized();
    pose.translation += AnyStep();
    map_.SetPose(id, pose);
    map_.SetParent(id, AnyKeyframe());
  }
  void Remove() {
    if (random_() % 4 == 0) {
      RemoveKeyframe(AnyKeyframe());
    } else if (const MapPointId id = AnyPoint(); id.local_map == kOwn) {
      map_.RemovePoint(id);
    } else {
      map_.RemoveObservation(AnyPoint(), AnyKeyframe());
    }
  }
  // Mapping never takes the root out. The map may, where trees are the same on both sides.
  void RemoveKeyframe(KeyframeId id) {
    const Keyframe* keyframe = map_.FindKeyframe(id);
    if (keyframe == nullptr || (store_.root_stays && !keyframe->parent.IsValid())) return;
    map_.RemoveKeyframe(id);
  }
  // Half of them too small to be seen from where the points are.
  Eigen::Vector3d AnyStep() {
    const double size_m = random_() % 2 == 0 ? 0.1 : 10;
    const auto any = [&] { return size_m * (static_cast<double>(random_() % 1000) / 500 - 1); };
    const double x = any();
    const double y = any();
    return {x, y, any()};
  }
  ptrdiff_t Below(size_t count) { return static_cast<ptrdiff_t>(random_() % count); }
  KeyframeId AnyKeyframe() {
    if (map_.keyframes().empty()) return {};
    return std::next(map_.keyframes().begin(), Below(map_.keyframes().size()))->first;
  }
  MapPointId AnyPoint() {
    return std::next(map_.points().begin(), Below(map_.points().size()))->first;
  }

  std::mt19937 random_;
  const RecorderOptions options_;
  std::unique_ptr<UpdateRecorder> recorder_;
  KeptMap kept_{kOwn};
  bool keeps_ = true;  // What an older store has is another map.
  bool restarted_ = false;
  Map map_;
  Map replica_;
  Store store_;
  uint32_t next_keyframe_ = 0;
  uint32_t next_point_ = 0;
};

TEST(UpdateRecorderTest, ReplicaFollowsRandomChanges) {
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    Scenario scenario(seed);
    std::mt19937 random(seed);
    for (int step = 0; step < 400; ++step) {
      scenario.Step();
      if (random() % 15 == 0) {
        scenario.Flush(1000);
        scenario.ExpectEqual();
        ASSERT_FALSE(scenario.HasChanges());
        ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed << " step " << step;
      }
    }
    scenario.ExpectExactPlaces();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed;
  }
}

TEST(UpdateRecorderTest, WhatIsKeptIsWhatTheStoreHas) {
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    Scenario scenario(seed);
    std::mt19937 random(seed);
    for (int step = 0; step < 300; ++step) {
      scenario.Step();
      if (random() % 15 != 0) continue;
      scenario.Flush(1000);
      scenario.ExpectKeptIsReplica();
      ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed << " step " << step;
    }
    scenario.Flush(1000);
    scenario.ExpectWholeIsTheSame();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed;
  }
}

// What was not in a batch is lost, and all that follows is told as if there had been no restart.
TEST(UpdateRecorderTest, ANextProcessGoesOnWithWhatIsKept) {
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    RecorderOptions options;
    options.hold_newest = 0;
    // The root stays.
    options.limits.light_keyframes = BatchLimits().light_keyframes - 1;
    Scenario scenario(seed, options);
    std::mt19937 random(seed);
    for (int step = 0; step < 400; ++step) {
      scenario.Step();
      if (random() % 15 != 0) continue;
      scenario.Flush(1000);
      if (random() % 4 == 0) scenario.Restart();
      scenario.ExpectEqual();
      scenario.ExpectKeptIsReplica();
      ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed << " step " << step;
    }
    scenario.ExpectExactPlaces();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed;
  }
}

TEST(UpdateRecorderTest, BatchesLimitedInKeyframesConvergeToTheSame) {
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    Scenario scenario(seed);
    std::mt19937 random(seed);
    for (int step = 0; step < 300; ++step) {
      scenario.Step();
      if (random() % 10 == 0) scenario.Flush(1);
    }
    for (int i = 0; i < 200 && scenario.HasChanges(); ++i) scenario.Flush(2);
    EXPECT_FALSE(scenario.HasChanges());
    scenario.ExpectEqual();
    scenario.ExpectExactPlaces();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed;
  }
}

constexpr BatchLimits kTinyLimits = {.full_points = 3,
                                     .light_keyframes = 2,
                                     .light_points = 2,
                                     .replacements = 1,
                                     .observations = 4,
                                     .removed_points = 1,
                                     .removed_keyframes = 1,
                                     .loop_edges = 1,
                                     .frames = 1,
                                     .pairs = 5};

// A backlog of any size goes up in batches that a store takes.
TEST(UpdateRecorderTest, BatchesLimitedInItemsConvergeToTheSame) {
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    Scenario scenario(seed, {.hold_newest = 0, .limits = kTinyLimits});
    std::mt19937 random(seed);
    const auto flush = [&] {
      const MapUpdateBatch batch = scenario.Flush(1);
      EXPECT_LE(batch.full_points.size(), kTinyLimits.full_points);
      EXPECT_LE(batch.light_keyframes.size(), kTinyLimits.light_keyframes);
      EXPECT_LE(batch.light_points.size(), kTinyLimits.light_points);
      EXPECT_LE(batch.replacements.size(), kTinyLimits.replacements);
      // One keyframe may lose and gain one at each of its keypoints.
      EXPECT_LT(batch.observations.size(), kTinyLimits.observations + 2 * kKeypoints);
      EXPECT_LE(batch.removed_points.size(), kTinyLimits.removed_points);
      EXPECT_LE(batch.removed_keyframes.size(), kTinyLimits.removed_keyframes);
    };
    for (int step = 0; step < 300; ++step) {
      scenario.Step();
      if (random() % 10 == 0) flush();
    }
    for (int i = 0; i < 2000 && scenario.HasChanges(); ++i) flush();
    EXPECT_FALSE(scenario.HasChanges());
    scenario.ExpectEqual();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed;
  }
}

TEST(UpdateRecorderTest, WhatIsHeldBackIsAllToldAtTheEnd) {
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    Scenario scenario(seed, {.hold_newest = 6});
    std::mt19937 random(seed);
    for (int step = 0; step < 400; ++step) {
      scenario.Step();
      if (random() % 15 != 0) continue;
      // As who sends does it: until there is nothing to tell.
      int batches = 0;
      while (!client_agent::IsEmpty(scenario.Flush(1 + random() % 10))) ASSERT_LT(++batches, 100);
    }
    scenario.ExpectExactPlaces();
    scenario.ExpectEqual();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed;
  }
}

TEST(UpdateRecorderTest, WhereFeaturesAreLeftOutTheOthersAreTold) {
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    Scenario scenario(seed, {.features = {seed % 2 == 0 ? 0u : 12u}, .hold_newest = seed % 4});
    std::mt19937 random(seed);
    for (int step = 0; step < 400; ++step) {
      scenario.Step();
      if (random() % 15 == 0) scenario.Flush(random() % 10);
    }
    scenario.ExpectExactPlaces();
    scenario.ExpectEqual();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed;
  }
}

TEST(UpdateRecorderTest, AStoreThatMovesNoPointsIsToldThemAll) {
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    Scenario scenario(seed);
    std::mt19937 random(seed);
    for (int step = 0; step < 400; ++step) {
      scenario.Step();
      if (random() % 15 == 0) scenario.Flush(1000);
      if (random() % 40 != 0) continue;
      scenario.ReplaceStore(random() % 2 == 0);
      // A batch that was made before the session says what the store can.
      scenario.Flush(1000);
      scenario.OpenSession();
      scenario.Flush(1000);
      scenario.ExpectEqual();
      ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed << " step " << step;
    }
    scenario.ExpectExactPlaces();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed;
  }
}

// Whatever is held back, and however long: no item is lost, none comes before what it refers to
// (Apply says so), points wait while a full keyframe does, and every batch tells something.
TEST(UpdateRecorderTest, BatchesLimitedInBytesConvergeToTheSame) {
  int all_batches = 0;
  for (uint32_t seed = 1; seed <= 40; ++seed) {
    Scenario scenario(seed);
    std::mt19937 random(seed);
    const auto flush = [&] {
      const MapUpdateBatch batch = scenario.FlushBytes(1 + static_cast<double>(random() % 4000));
      if (scenario.CountUntold()[static_cast<size_t>(UpdateKind::kKeyframes)] == 0) return batch;
      EXPECT_FALSE(batch.full_keyframes.empty());
      EXPECT_TRUE(batch.full_points.empty());
      EXPECT_TRUE(batch.light_points.empty());
      return batch;
    };
    for (int step = 0; step < 300; ++step) {
      scenario.Step();
      if (random() % 10 == 0) flush();
    }
    int batches = 0;
    for (; batches < 5000 && scenario.HasChanges(); ++batches) {
      // An empty one would close the local map.
      EXPECT_TRUE(!client_agent::IsEmpty(flush()) || !scenario.HasChanges());
    }
    all_batches += batches;
    EXPECT_FALSE(scenario.HasChanges());
    scenario.ExpectEqual();
    scenario.ExpectExactPlaces();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed;
  }
  EXPECT_GT(all_batches, 80);
}

class RecordedMapTest : public ::testing::Test {
 protected:
  RecordedMapTest() { map_.SetObserver(&recorder_); }

  static MapPoint Point(MapPointId id) {
    MapPoint point;
    point.id = id;
    return point;
  }

  UpdateRecorder recorder_{kOwn, RecorderOptions{.hold_newest = 0}};
  Map map_;
};

TEST_F(RecordedMapTest, ForeignItemsAreTheirOwnersToTell) {
  map_.AddKeyframe(MakeKeyframe({kForeign, 0}, {}));
  MapPoint point = Point({kForeign, 0});
  map_.AddPoint(point);
  map_.AddObservation(point.id, {kForeign, 0}, 0);
  EXPECT_FALSE(recorder_.HasChanges());
}

TEST_F(RecordedMapTest, UnloadingAForeignPointIsNotRemoval) {
  map_.AddKeyframe(MakeKeyframe({kOwn, 0}, {}));
  MapPoint point = Point({kForeign, 0});
  map_.AddPoint(point);
  map_.AddObservation(point.id, {kOwn, 0}, 3);
  EXPECT_EQ(recorder_.TakeBatch(map_, 10).observations.size(), 1U);
  map_.RemovePoint(point.id);
  const MapUpdateBatch batch = recorder_.TakeBatch(map_, 10);
  EXPECT_TRUE(batch.observations.empty());
  EXPECT_TRUE(batch.removed_points.empty());
}

TEST_F(RecordedMapTest, AForeignPointThatComesBackIsNotRemovedFromWhereItWas) {
  map_.AddKeyframe(MakeKeyframe({kOwn, 0}, {}));
  MapPoint point = Point({kForeign, 0});
  MapPoint other = Point({kForeign, 1});
  map_.AddPoint(point);
  map_.AddPoint(other);
  map_.AddObservation(point.id, {kOwn, 0}, 3);
  EXPECT_EQ(recorder_.TakeBatch(map_, 10).observations.size(), 1U);
  map_.RemovePoint(point.id);
  map_.AddPoint(point);
  map_.AddObservation(other.id, {kOwn, 0}, 4);
  const MapUpdateBatch batch = recorder_.TakeBatch(map_, 10);
  ASSERT_EQ(batch.observations.size(), 1U);
  EXPECT_EQ(batch.observations[0].point, other.id);
  // One that the robot takes back itself is told.
  map_.RemoveObservation(other.id, {kOwn, 0});
  const MapUpdateBatch next = recorder_.TakeBatch(map_, 10);
  ASSERT_EQ(next.observations.size(), 1U);
  EXPECT_EQ(next.observations[0].kind, ObservationChange::Kind::kRemoved);
}

TEST_F(RecordedMapTest, APointThatComesBackStandsForItselfAgain) {
  map_.AddKeyframe(MakeKeyframe({kOwn, 0}, {}));
  MapPoint own = Point({kOwn, 0});
  own.reference = {kOwn, 0};
  MapPoint foreign = Point({kForeign, 0});
  map_.AddPoint(own);
  map_.AddObservation(own.id, {kOwn, 0}, 3);
  map_.AddPoint(foreign);
  recorder_.TakeBatch(map_, 10);
  ASSERT_TRUE(map_.ReplacePoint(foreign.id, own.id));
  map_.AddPoint(foreign);
  ASSERT_TRUE(map_.ReplacePoint(own.id, foreign.id));
  const MapUpdateBatch batch = recorder_.TakeBatch(map_, 10);
  ASSERT_EQ(batch.replacements.size(), 1U);
  EXPECT_EQ(batch.replacements[0].replaced, own.id);
  EXPECT_EQ(batch.replacements[0].survivor, foreign.id);
}

// Ten points before a keyframe, 10 m away: half a pixel is a centimetre there.
class RecordedPlacesTest : public RecordedMapTest {
 protected:
  RecordedPlacesTest() {
    map_.AddKeyframe(MakeKeyframe({kOwn, 0}, {}));
    for (uint32_t i = 0; i < 10; ++i) {
      MapPoint point = Point({kOwn, i});
      point.reference = {kOwn, 0};
      point.position_in_map = {i * 0.1, 0, 10};
      map_.AddPoint(point);
      map_.AddObservation(point.id, {kOwn, 0}, i);
    }
    EXPECT_EQ(recorder_.TakeBatch(map_, 10).full_points.size(), 10u);
  }

  void Shift(uint32_t point, double x_m) {
    const Eigen::Vector3d before = map_.FindPoint({kOwn, point})->position_in_map;
    map_.SetPosition({kOwn, point}, before + Eigen::Vector3d(x_m, 0, 0));
  }
};

TEST_F(RecordedPlacesTest, WhatNobodySeesMoveIsNotTold) {
  Shift(3, 0.009);
  Shift(4, 0.011);
  const MapUpdateBatch batch = recorder_.TakeBatch(map_, 10);
  ASSERT_EQ(batch.light_points.size(), 1u);
  EXPECT_EQ(batch.light_points[0].id, (MapPointId{kOwn, 4}));
  // Small motions add up.
  Shift(3, 0.009);
  EXPECT_EQ(recorder_.TakeBatch(map_, 10).light_points.size(), 1u);
}

TEST_F(RecordedPlacesTest, ACorrectionIsToldInPosesAlone) {
  const Rigid3d correction = {Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY())),
                              {3, 0.2, -1}};
  map_.SetPose({kOwn, 0}, map_.FindKeyframe({kOwn, 0})->camera_from_map * correction.Inverse());
  for (uint32_t i = 0; i < 10; ++i) {
    map_.SetPosition({kOwn, i}, correction * map_.FindPoint({kOwn, i})->position_in_map);
  }
  const MapUpdateBatch batch = recorder_.TakeBatch(map_, 10);
  EXPECT_EQ(batch.light_keyframes.size(), 1u);
  EXPECT_TRUE(batch.light_points.empty());
}

TEST_F(RecordedPlacesTest, PointsThatStayWhileTheirKeyframeMovesAreTold) {
  map_.SetPose({kOwn, 0}, {Eigen::Quaterniond::Identity(), {0.1, 0, 0}});
  EXPECT_EQ(recorder_.TakeBatch(map_, 10).light_points.size(), 10u);
}

TEST_F(RecordedPlacesTest, WhoAsksGetsExactPlaces) {
  Shift(3, 0.001);
  recorder_.AskForExactPlaces();
  ASSERT_TRUE(recorder_.HasChanges());
  EXPECT_EQ(recorder_.TakeBatch(map_, 10).light_points.size(), 1u);
  EXPECT_FALSE(recorder_.HasChanges());
  Shift(3, 0.001);
  EXPECT_TRUE(recorder_.TakeBatch(map_, 10).light_points.empty());
}

// A byte is left: one of what matters most goes.
TEST_F(RecordedPlacesTest, WhatMattersMostGoesFirst) {
  const auto take = [this](double bytes) {
    return CountUpdates(recorder_.TakeBatch(map_, BatchAllowance(10, bytes, 1)));
  };
  for (uint32_t k = 1; k <= 3; ++k) map_.AddKeyframe(MakeKeyframe({kOwn, k}, {kOwn, 0}));
  for (uint32_t i = 20; i < 23; ++i) {
    MapPoint point = Point({kOwn, i});
    point.reference = {kOwn, 0};
    map_.AddPoint(point);
  }
  for (uint32_t i = 0; i < 3; ++i) Shift(i, 5);
  for (int i = 0; i < 100; ++i) recorder_.AddTrackedFrame({i, {kOwn, 0}, {}});
  recorder_.AddLostFrame(100);
  // All poses; a keyframe even then.
  EXPECT_EQ(take(1), (UpdateCounts{101, 1, 0, 0}));
  EXPECT_EQ(recorder_.CountUntold(), (UpdateCounts{0, 2, 3, 3}));
  recorder_.AddTrackedFrame({101, {kOwn, 1}, {}});
  recorder_.AddTrackedFrame({102, {kOwn, 3}, {}});
  EXPECT_EQ(take(1), (UpdateCounts{1, 1, 0, 0})) << "a frame waits for its keyframe";
  EXPECT_EQ(take(1), (UpdateCounts{1, 1, 0, 0}));
  EXPECT_EQ(take(100), (UpdateCounts{0, 0, 2, 0}));
  EXPECT_EQ(take(100), (UpdateCounts{0, 0, 1, 3}));
  EXPECT_FALSE(recorder_.HasChanges());
}

// The store hears where it is in the end, once.
TEST_F(RecordedPlacesTest, WhatIsHeldBackIsToldOnce) {
  map_.AddKeyframe(MakeKeyframe({kOwn, 1}, {kOwn, 0}));
  map_.AddKeyframe(MakeKeyframe({kOwn, 2}, {kOwn, 0}));
  for (int i = 0; i < 10; ++i) Shift(4, 1);
  EXPECT_TRUE(recorder_.TakeBatch(map_, BatchAllowance(10, 1, 1)).light_points.empty());
  for (int i = 0; i < 10; ++i) Shift(4, 1);
  EXPECT_TRUE(recorder_.TakeBatch(map_, BatchAllowance(10, 1, 1)).light_points.empty());
  const MapUpdateBatch batch = recorder_.TakeBatch(map_, BatchAllowance(10, 1, 1));
  ASSERT_EQ(batch.light_points.size(), 1u);
  EXPECT_NEAR(batch.light_points[0].position_in_local.x(), 20.4, 1e-9);
  EXPECT_FALSE(recorder_.HasChanges());
}

TEST_F(RecordedMapTest, FramesBeyondABatchGoIntoTheNext) {
  for (int i = 0; i < 50000; ++i) {
    recorder_.AddLostFrame(i);
    recorder_.AddTrackedFrame({i, {kOwn, 0}, {}});
  }
  size_t lost = 0;
  size_t tracked = 0;
  for (int batches = 0; batches < 2; ++batches) {
    const MapUpdateBatch batch = recorder_.TakeBatch(map_, 10);
    EXPECT_LE(batch.lost_frames_ns.size(), 40000U);
    EXPECT_LE(batch.tracked_frames.size(), 40000U);
    lost += batch.lost_frames_ns.size();
    tracked += batch.tracked_frames.size();
  }
  EXPECT_EQ(lost, 50000U);
  EXPECT_EQ(tracked, 50000U);
}

TEST_F(RecordedMapTest, AHugeBacklogGoesUpInBatchesThatAStoreTakes) {
  constexpr uint32_t kMany = 150000;
  constexpr size_t kStoreTakes = 1000000;
  Keyframe keyframe = MakeKeyframe({kOwn, 0}, {});
  for (uint32_t i = 0; i < kMany; ++i) {
    keyframe.payload = MakeKeyframePayload({kOwn, i}, i, 0, keyframe.payload->camera, {});
    keyframe.parent = i == 0 ? KeyframeId() : KeyframeId{kOwn, 0};
    map_.AddKeyframe(keyframe);
  }
  while (!corbslam::client_agent::IsEmpty(recorder_.TakeBatch(map_, kMany))) {
  }
  // The whole map moves, and a long way was tracked meanwhile.
  for (uint32_t i = 0; i < kMany; ++i) {
    map_.SetPose({kOwn, i}, {Eigen::Quaterniond::Identity(), {1, 0, 0}});
    recorder_.AddTrackedFrame({i, {kOwn, i}, {}});
    recorder_.AddTrackedFrame({i, {kOwn, i}, {}});
    recorder_.AddTrackedFrame({i, {kOwn, i}, {}});
  }
  size_t keyframes = 0;
  size_t frames = 0;
  while (true) {
    const MapUpdateBatch batch = recorder_.TakeBatch(map_, 8);
    if (corbslam::client_agent::IsEmpty(batch)) break;
    EXPECT_LT(batch.light_keyframes.size() + batch.tracked_frames.size(), kStoreTakes / 2);
    keyframes += batch.light_keyframes.size();
    frames += batch.tracked_frames.size();
  }
  EXPECT_EQ(keyframes, kMany);
  EXPECT_EQ(frames, 3 * kMany);
}

TEST_F(RecordedMapTest, WhatHasImpossibleValuesIsNotTold) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  map_.AddKeyframe(MakeKeyframe({kOwn, 0}, {}));
  Keyframe bad = MakeKeyframe({kOwn, 1}, {kOwn, 0});
  bad.camera_from_map.translation.x() = kNan;
  map_.AddKeyframe(bad);
  map_.AddKeyframe(MakeKeyframe({kOwn, 2}, {kOwn, 1}));
  map_.AddLoopEdge({kOwn, 1}, {kOwn, 0});
  recorder_.AddTrackedFrame({5, {kOwn, 1}, {}});
  recorder_.AddTrackedFrame({6, {kOwn, 0}, {}});
  recorder_.AddTrackedFrame({-7, {kOwn, 0}, {}});
  const MapUpdateBatch batch = recorder_.TakeBatch(map_, 10);
  ASSERT_EQ(batch.full_keyframes.size(), 2u);
  EXPECT_EQ(batch.full_keyframes[1].payload->id, (KeyframeId{kOwn, 2}));
  EXPECT_EQ(batch.full_keyframes[1].parent, (KeyframeId{kOwn, 0})) << "past the one left out";
  EXPECT_TRUE(batch.loop_edges.empty());
  ASSERT_EQ(batch.tracked_frames.size(), 1u);
  EXPECT_EQ(batch.tracked_frames[0].timestamp_ns, 6);
  EXPECT_EQ(recorder_.refused_items(), 2u) << "the keyframe, and the frame before all time";
  EXPECT_FALSE(recorder_.HasChanges());

  // One that was told stays where it was until it has a place again.
  const auto move = [&](double x) {
    map_.SetPose({kOwn, 2}, {Eigen::Quaterniond::Identity(), {x, 0, 0}});
    return recorder_.TakeBatch(map_, 10).light_keyframes;
  };
  EXPECT_TRUE(move(kNan).empty());
  EXPECT_EQ(recorder_.refused_items(), 3u);
  EXPECT_EQ(move(1).size(), 1u);
}

// What comes after it is told all the same, by a batch that is not empty.
TEST_F(RecordedMapTest, WhatIsRefusedTakesNoRoomInABatch) {
  UpdateRecorder recorder(kOwn,
                          {.hold_newest = 0, .limits = {.removed_keyframes = 1, .frames = 1}});
  map_.SetObserver(&recorder);
  map_.AddKeyframe(MakeKeyframe({kOwn, 0}, {}));
  Keyframe bad = MakeKeyframe({kOwn, 1}, {kOwn, 0});
  bad.camera_from_map.translation.x() = std::numeric_limits<double>::quiet_NaN();
  map_.AddKeyframe(bad);
  map_.AddKeyframe(MakeKeyframe({kOwn, 2}, {kOwn, 0}));
  EXPECT_EQ(recorder.TakeBatch(map_, 10).full_keyframes.size(), 2u);

  map_.RemoveKeyframe({kOwn, 1});
  map_.RemoveKeyframe({kOwn, 2});
  recorder.AddTrackedFrame({5, {kOwn, 1}, {}});
  for (const int64_t time_ns : {-7, -6, 8}) recorder.AddLostFrame(time_ns);
  const MapUpdateBatch batch = recorder.TakeBatch(map_, 10);
  ASSERT_EQ(batch.removed_keyframes.size(), 1u);
  EXPECT_EQ(batch.removed_keyframes[0].id, (KeyframeId{kOwn, 2}));
  EXPECT_THAT(batch.lost_frames_ns, ElementsAre(8));
  EXPECT_THAT(batch.tracked_frames, IsEmpty()) << "nobody knows where its keyframe was";
  EXPECT_FALSE(recorder.HasChanges());
}

TEST_F(RecordedMapTest, FramesWaitForTheirReference) {
  map_.AddKeyframe(MakeKeyframe({kOwn, 0}, {}));
  map_.AddKeyframe(MakeKeyframe({kOwn, 1}, {kOwn, 0}));
  recorder_.AddTrackedFrame({100, {kOwn, 0}, {}});
  recorder_.AddTrackedFrame({200, {kOwn, 1}, {}});
  EXPECT_EQ(recorder_.TakeBatch(map_, 1).tracked_frames.size(), 1U);
  EXPECT_EQ(recorder_.TakeBatch(map_, 1).tracked_frames.size(), 1U);
}

TEST_F(RecordedMapTest, CameraGoesOnceBeforeItsFirstKeyframe) {
  map_.AddKeyframe(MakeKeyframe({kOwn, 0}, {}));
  EXPECT_EQ(recorder_.TakeBatch(map_, 9).cameras.size(), 1U);
  map_.AddKeyframe(MakeKeyframe({kOwn, 1}, {kOwn, 0}));
  EXPECT_EQ(recorder_.TakeBatch(map_, 9).cameras.size(), 0U);
}

class HoldingRecorderTest : public ::testing::Test {
 protected:
  HoldingRecorderTest() { map_.SetObserver(&recorder_); }

  // One a tenth of a second; frames come as fast.
  void AddKeyframe(uint32_t index) {
    Keyframe keyframe =
        MakeKeyframe({kOwn, index}, index == 0 ? KeyframeId() : KeyframeId{kOwn, 0});
    keyframe.payload = MakeKeyframePayload({kOwn, index}, TimeOf(index), 0,
                                           keyframe.payload->camera, keyframe.payload->features);
    map_.AddKeyframe(keyframe);
    recorder_.AddTrackedFrame({TimeOf(index), {kOwn, index}, {}});
  }
  static int64_t TimeOf(uint32_t index) { return int64_t{index} * 100'000'000; }
  std::vector<uint32_t> TakeKeyframes() {
    std::vector<uint32_t> taken;
    const MapUpdateBatch batch = recorder_.TakeBatch(map_, 100);
    for (const FullKeyframe& full : batch.full_keyframes) taken.push_back(full.payload->id.index);
    frames_ += batch.tracked_frames.size();
    return taken;
  }

  UpdateRecorder recorder_{kOwn,
                           RecorderOptions{.hold_newest = 3, .hold_at_most_ns = 3'000'000'000}};
  Map map_;
  size_t frames_ = 0;
};

TEST_F(HoldingRecorderTest, TheFirstGoesAtOnceTheNewestWait) {
  AddKeyframe(0);
  EXPECT_THAT(TakeKeyframes(), ElementsAre(0));
  for (uint32_t i = 1; i < 4; ++i) AddKeyframe(i);
  EXPECT_THAT(TakeKeyframes(), IsEmpty());
  EXPECT_EQ(frames_, 1u) << "frames wait with their keyframes";
  AddKeyframe(4);
  EXPECT_THAT(TakeKeyframes(), ElementsAre(1));
  EXPECT_EQ(frames_, 2u);
}

TEST_F(HoldingRecorderTest, WhatIsTakenOutMeanwhileIsNeverTold) {
  for (uint32_t i = 0; i < 4; ++i) AddKeyframe(i);
  EXPECT_THAT(TakeKeyframes(), ElementsAre(0));
  map_.RemoveKeyframe({kOwn, 2});
  AddKeyframe(4);
  EXPECT_THAT(TakeKeyframes(), IsEmpty()) << "1, 3 and 4 are the newest";
  AddKeyframe(5);
  AddKeyframe(6);
  EXPECT_THAT(TakeKeyframes(), ElementsAre(1, 3));
}

TEST_F(HoldingRecorderTest, WhoHangsOnOneThatWaitsIsToldOnceNowAndOnceThen) {
  for (uint32_t i = 0; i < 5; ++i) AddKeyframe(i);
  EXPECT_THAT(TakeKeyframes(), ElementsAre(0, 1));
  ASSERT_TRUE(map_.SetParent({kOwn, 1}, {kOwn, 4}));
  const MapUpdateBatch now = recorder_.TakeBatch(map_, 10);
  ASSERT_EQ(now.light_keyframes.size(), 1u);
  EXPECT_EQ(now.light_keyframes[0].parent, (KeyframeId{kOwn, 0}));
  EXPECT_TRUE(client_agent::IsEmpty(recorder_.TakeBatch(map_, 10)));
  recorder_.StopHoldingBack();
  const MapUpdateBatch then = recorder_.TakeBatch(map_, 10);
  ASSERT_EQ(then.light_keyframes.size(), 1u);
  EXPECT_EQ(then.light_keyframes[0].parent, (KeyframeId{kOwn, 4}));
}

TEST_F(HoldingRecorderTest, KeypointsStayOnceTheyAreTold) {
  for (uint32_t i = 0; i < 3; ++i) AddKeyframe(i);
  EXPECT_TRUE(recorder_.MayChangeKeypoints({kOwn, 0}));
  EXPECT_THAT(TakeKeyframes(), ElementsAre(0));
  EXPECT_FALSE(recorder_.MayChangeKeypoints({kOwn, 0}));
  EXPECT_TRUE(recorder_.MayChangeKeypoints({kOwn, 1}));
  std::vector<Keypoint> keypoints = map_.FindKeyframe({kOwn, 1})->keypoints();
  keypoints[4].x_px = 44;
  EXPECT_TRUE(map_.SetKeypoints({kOwn, 1}, keypoints));
  recorder_.StopHoldingBack();
  const MapUpdateBatch batch = recorder_.TakeBatch(map_, 9);
  ASSERT_EQ(batch.full_keyframes.size(), 2u);
  EXPECT_EQ(batch.full_keyframes[0].payload->features.keypoints[4].x_px, 44);
}

TEST_F(HoldingRecorderTest, NoneWaitsForLong) {
  for (uint32_t i = 0; i < 3; ++i) AddKeyframe(i);
  recorder_.AddTrackedFrame({TimeOf(31), {kOwn, 2}, {}});
  EXPECT_THAT(TakeKeyframes(), ElementsAre(0));
  recorder_.AddLostFrame(TimeOf(32));
  EXPECT_THAT(TakeKeyframes(), ElementsAre(1));
}

TEST_F(HoldingRecorderTest, NothingWaitsWhereNoFramesCome) {
  for (uint32_t i = 0; i < 3; ++i) AddKeyframe(i);
  recorder_.StopHoldingBack();
  EXPECT_THAT(TakeKeyframes(), ElementsAre(0, 1, 2));
  AddKeyframe(3);
  EXPECT_THAT(TakeKeyframes(), IsEmpty());
}

TEST_F(HoldingRecorderTest, PointsThatMoveOnAreToldOnceInAWhile) {
  AddKeyframe(0);
  MapPoint point;
  point.id = {kOwn, 0};
  point.position_in_map = {0, 0, 5};
  point.reference = {kOwn, 0};
  map_.AddPoint(point);
  map_.AddObservation(point.id, {kOwn, 0}, 0);
  EXPECT_EQ(recorder_.TakeBatch(map_, 9).full_points.size(), 1u);
  const auto move_and_take = [&](double x, int64_t frame_ns) {
    map_.SetPosition(point.id, {x, 0, 5});
    recorder_.AddTrackedFrame({frame_ns, {kOwn, 0}, {}});
    return recorder_.TakeBatch(map_, 9).light_points;
  };
  EXPECT_EQ(move_and_take(0.1, TimeOf(1)).size(), 1u);
  EXPECT_THAT(move_and_take(0.2, TimeOf(2)), IsEmpty());
  EXPECT_THAT(move_and_take(0.3, TimeOf(20)), IsEmpty());
  const std::vector<LightMapPoint> told = move_and_take(0.4, TimeOf(21));
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].position_in_local.x(), 0.4);
  // A clock that was set back.
  EXPECT_EQ(move_and_take(0.5, TimeOf(0)).size(), 1u);
  EXPECT_THAT(move_and_take(0.6, TimeOf(1)), IsEmpty());
  recorder_.AskForExactPlaces();
  EXPECT_EQ(recorder_.TakeBatch(map_, 9).light_points.size(), 1u);
  EXPECT_THAT(move_and_take(0.7, TimeOf(2)), IsEmpty());
  recorder_.StopHoldingBack();
  EXPECT_EQ(recorder_.TakeBatch(map_, 9).light_points.size(), 1u);
}

TEST_F(HoldingRecorderTest, WhoAsksForExactPlacesIsToldAll) {
  for (uint32_t i = 0; i < 3; ++i) AddKeyframe(i);
  recorder_.AskForExactPlaces();
  EXPECT_THAT(TakeKeyframes(), ElementsAre(0, 1, 2));
}

TEST_F(HoldingRecorderTest, WhatCanNeverBeToldKeepsNothingExact) {
  AddKeyframe(0);
  // Only another's keyframe sees it.
  map_.AddKeyframe(MakeKeyframe({kForeign, 0}, {}));
  MapPoint point;
  point.id = {kOwn, 0};
  point.reference = {kForeign, 0};
  map_.AddPoint(point);
  map_.AddObservation(point.id, {kForeign, 0}, 0);
  recorder_.AskForExactPlaces();
  EXPECT_THAT(TakeKeyframes(), ElementsAre(0));
  EXPECT_TRUE(recorder_.HasChanges());
  EXPECT_THAT(TakeKeyframes(), IsEmpty());
  for (uint32_t i = 1; i < 4; ++i) AddKeyframe(i);
  EXPECT_THAT(TakeKeyframes(), IsEmpty()) << "held back again";
}

TEST(RecordedCameraTest, GoesUpOnceWithItsCamera) {
  RecordedCamera recorded;
  recorded.lens.fx_px = 400;
  recorded.lens.fy_px = 400;
  UpdateRecorder recorder(kOwn, RecorderOptions{.recorded_camera = recorded});
  Map map;
  map.SetObserver(&recorder);
  map.AddKeyframe(MakeKeyframe({kOwn, 0}, {}));
  const MapUpdateBatch first = recorder.TakeBatch(map, 10);
  ASSERT_EQ(first.cameras.size(), 1u);
  EXPECT_EQ(first.recorded_cameras, std::vector<RecordedCamera>{recorded});
  map.AddKeyframe(MakeKeyframe({kOwn, 1}, {kOwn, 0}));
  EXPECT_TRUE(recorder.TakeBatch(map, 10).recorded_cameras.empty());
}

}  // namespace
}  // namespace corbslam::client_agent
